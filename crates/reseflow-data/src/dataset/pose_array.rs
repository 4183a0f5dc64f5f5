//! Poses as 4 × 4 matrices, row by row, in flat `float32` arrays.

use reseflow_lie::{Matrix4, SE3};

/// Numbers per pose.
const ENTRIES: usize = 16;

/// Appends a pose's matrix.
pub(crate) fn push_pose(entries: &mut Vec<f32>, pose: &SE3) {
    let matrix = pose.matrix();
    for row in 0..4 {
        for column in 0..4 {
            entries.push(matrix[(row, column)] as f32);
        }
    }
}

/// Reads the pose at flat position `at`, as the rotation nearest to the stored matrix.
///
/// # Errors
/// Why the matrix is no rigid transform.
pub(crate) fn pose_at(entries: &[f32], at: usize) -> Result<SE3, String> {
    let entries = &entries[ENTRIES * at..][..ENTRIES];
    let matrix = Matrix4::from_row_iterator(entries.iter().map(|&entry| f64::from(entry)));
    SE3::from_matrix(&matrix).map_err(|fault| format!("is no rigid transform: {fault}"))
}
