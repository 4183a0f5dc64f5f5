//! Colours: hue, saturation, value, after Smith, "Color gamut transform pairs" (1978).

/// The sRGB colour with hue `hue` (turns, any real), saturation and value in \[0, 1\].
pub(crate) fn rgb_from_hsv(hue: f64, saturation: f64, value: f64) -> [u8; 3] {
    let channel = |offset: f64| {
        let k = (offset + hue * 6.0).rem_euclid(6.0);
        let level = value * (1.0 - saturation * k.min(4.0 - k).clamp(0.0, 1.0));
        (level * 255.0).round() as u8
    };
    [channel(5.0), channel(3.0), channel(1.0)]
}

/// Saturation and value of an sRGB colour, both in \[0, 1\].
pub(crate) fn saturation_and_value(rgb: [u8; 3]) -> (f64, f64) {
    let high = f64::from(rgb[0].max(rgb[1]).max(rgb[2]));
    let low = f64::from(rgb[0].min(rgb[1]).min(rgb[2]));
    let saturation = if high > 0.0 { (high - low) / high } else { 0.0 };
    (saturation, high / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primaries_have_their_hues() {
        assert_eq!(rgb_from_hsv(0.0, 1.0, 1.0), [255, 0, 0]);
        assert_eq!(rgb_from_hsv(1.0 / 3.0, 1.0, 1.0), [0, 255, 0]);
        assert_eq!(rgb_from_hsv(2.0 / 3.0, 1.0, 1.0), [0, 0, 255]);
    }

    #[test]
    fn saturation_and_value_invert_the_map() {
        for step in 0..60 {
            let (hue, saturation, value) = (f64::from(step) / 60.0, 0.6, 0.8);
            let (s, v) = saturation_and_value(rgb_from_hsv(hue, saturation, value));
            assert!((s - saturation).abs() < 0.01 && (v - value).abs() < 0.01, "hue {hue}: {s} {v}");
        }
    }
}
