//! Films as animated GIFs.

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, DynamicImage, Frame, RgbImage};

use super::PlotError;

/// What errors call it.
const PICTURE: &str = "the film";
/// How thoroughly colours are chosen, from 1 (best) to 30 (fastest).
const SPEED: i32 = 10;

/// An endless film, each frame shown for `frame_millis`.
///
/// # Errors
/// When there is no frame or the encoder fails.
pub fn encode_gif(frames: Vec<RgbImage>, frame_millis: u32) -> Result<Vec<u8>, PlotError> {
    if frames.is_empty() {
        return Err(PlotError::new(PICTURE, "there is no frame"));
    }
    let mut bytes = Vec::new();
    let mut encoder = GifEncoder::new_with_speed(&mut bytes, SPEED);
    let fault = |reason| PlotError::new(PICTURE, reason);
    encoder.set_repeat(Repeat::Infinite).map_err(fault)?;
    let delay = Delay::from_numer_denom_ms(frame_millis, 1);
    for image in frames {
        let frame = Frame::from_parts(DynamicImage::ImageRgb8(image).into_rgba8(), 0, 0, delay);
        encoder.encode_frame(frame).map_err(fault)?;
    }
    drop(encoder);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::codecs::gif::GifDecoder;
    use image::{AnimationDecoder, Rgb};

    #[test]
    fn a_film_holds_its_frames_in_order() {
        let frames = [10, 120, 230].map(|level| RgbImage::from_pixel(8, 6, Rgb([level, 40, 40])));
        let bytes = encode_gif(frames.to_vec(), 200).unwrap();
        let decoder = GifDecoder::new(std::io::Cursor::new(bytes)).unwrap();
        let read = decoder.into_frames().collect_frames().unwrap();
        assert_eq!(read.len(), 3);
        for (frame, level) in read.iter().zip([10_i16, 120, 230]) {
            assert_eq!(frame.delay().numer_denom_ms(), (200, 1));
            let red = i16::from(frame.buffer().get_pixel(3, 3).0[0]);
            assert!((red - level).abs() < 8, "{red} for {level}");
        }
        assert!(encode_gif(Vec::new(), 200).is_err());
    }
}
