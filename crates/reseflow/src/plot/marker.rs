//! What stands at the points of a line.

use std::f64::consts::TAU;

use super::picture::{Ink, Picture, Stroke};

/// Corners of the polygon that a ring is drawn as.
const RING_CORNERS: u32 = 32;

/// What stands at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// A disc.
    Disc,
    /// A circle that leaves room for another marker inside.
    Ring,
    /// A square.
    Square,
    /// A triangle.
    Triangle,
    /// A square on its corner.
    Diamond,
    /// Two crossing strokes.
    Cross,
}

impl Picture {
    /// A marker of this radius.
    pub fn marker(&mut self, (x, y): (f64, f64), marker: Marker, ink: Ink, radius: f64) {
        let r = radius;
        match marker {
            Marker::Disc => self.disc((x, y), r, ink, 1.0),
            Marker::Ring => {
                let r = 1.4 * r;
                // Two arcs, each a corner longer than half of it, so that their ends leave no notch.
                for first in [0, RING_CORNERS / 2] {
                    let corners = first..=first + RING_CORNERS / 2 + 1;
                    let angles = corners.map(|corner| TAU * f64::from(corner) / f64::from(RING_CORNERS));
                    let places = angles.map(|angle| (x + r * angle.cos(), y + r * angle.sin()));
                    self.line(places, Stroke::solid(ink, 0.3 * r));
                }
            }
            Marker::Square => {
                let r = 0.88 * r;
                self.rectangle((x - r, y - r), (2.0 * r, 2.0 * r), ink);
            }
            Marker::Triangle => {
                let (wide, low) = (1.05 * r, 0.7 * r);
                self.area([(x, y - 1.15 * r), (x + wide, y + low), (x - wide, y + low)], ink, 1.0);
            }
            Marker::Diamond => {
                let r = 1.2 * r;
                self.area([(x, y - r), (x + r, y), (x, y + r), (x - r, y)], ink, 1.0);
            }
            Marker::Cross => {
                let stroke = Stroke::solid(ink, 0.5 * r);
                self.line([(x - r, y - r), (x + r, y + r)], stroke);
                self.line([(x - r, y + r), (x + r, y - r)], stroke);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::PALETTE;

    #[test]
    fn a_ring_is_closed() {
        let mut picture = Picture::new("a ring", 40.0, 40.0);
        picture.marker((20.0, 20.0), Marker::Ring, PALETTE[0], 6.0);
        let image = picture.image().unwrap();
        for degree in 0..360 {
            let (sin, cos) = f64::from(degree).to_radians().sin_cos();
            // Its radius is 1.4 times that of other markers, and a unit two pixels.
            let at = (40.0 + 16.8 * cos, 40.0 + 16.8 * sin);
            let pixel = image.get_pixel(at.0 as u32, at.1 as u32);
            assert!(pixel.0[0] < 60, "a gap at {degree} degrees: {pixel:?}");
        }
    }

    #[test]
    fn a_ring_is_seen_around_every_other_marker() {
        let ring_ink = PALETTE[0];
        let blue = |over: Option<Marker>| {
            let mut picture = Picture::new("markers", 40.0, 40.0);
            picture.marker((20.0, 20.0), Marker::Ring, ring_ink, 6.0);
            if let Some(over) = over {
                picture.marker((20.0, 20.0), over, PALETTE[1], 6.0);
            }
            let image = picture.image().unwrap();
            assert_eq!(image.get_pixel(40, 40).0 == [255; 3], over.is_none(), "its middle is open");
            image.pixels().filter(|pixel| pixel.0 == [ring_ink.0, ring_ink.1, ring_ink.2]).count()
        };
        let alone = blue(None);
        // A circle of radius 8.4 and width 2.5 has four pixels on each unit; its blurred edges do not count.
        assert!((250..540).contains(&alone), "{alone} pixels");
        for over in [Marker::Disc, Marker::Square, Marker::Triangle, Marker::Diamond, Marker::Cross] {
            assert!(2 * blue(Some(over)) > alone, "{over:?} hides the ring: {} of {alone}", blue(Some(over)));
        }
    }
}
