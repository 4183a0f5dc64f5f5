//! Coloured point clouds in the world frame.

/// A coloured point cloud, as a depth camera sees it after points were chosen.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointCloud {
    /// Positions in the world frame, metres.
    pub points: Vec<[f32; 3]>,
    /// One colour per point, sRGB, 0–255.
    pub colors: Vec<[u8; 3]>,
}

impl PointCloud {
    /// The number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is no point at all.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}
