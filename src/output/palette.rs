//! At most 256 colours for a picture, as GIF wants: median cut (Heckbert 1982) of the colours that
//! occur.
//!
//! Boxes are cut by their extent and the root of their number of pixels: a thin line and the colour
//! bar get their colours although few pixels show them.

/// Bits kept of each of red, green and blue.
const BITS: u32 = 6;

/// A colour that occurs, and how many pixels have it.
#[derive(Clone, Copy)]
struct Colour {
    rgb: [u8; 3],
    pixels: f64,
}

/// The palette (red, green and blue in turn) and the entry of every pixel.
pub(super) fn reduce(rgb: &[u8]) -> (Vec<u8>, Vec<u8>) {
    let mut pixels = vec![0u32; 1 << (3 * BITS)];
    rgb.chunks_exact(3).for_each(|p| pixels[bin(p)] += 1);
    let occurring = (0..pixels.len()).filter(|&k| pixels[k] > 0);
    let boxes =
        cut(occurring.map(|k| Colour { rgb: colour(k), pixels: f64::from(pixels[k]) }).collect());
    let mut palette = Vec::with_capacity(3 * boxes.len());
    let mut entry = vec![0u8; pixels.len()];
    for (i, members) in boxes.iter().enumerate() {
        let all: f64 = members.iter().map(|c| c.pixels).sum();
        for k in 0..3 {
            let mean = members.iter().map(|c| f64::from(c.rgb[k]) * c.pixels).sum::<f64>() / all;
            palette.push(mean.round() as u8);
        }
        members.iter().for_each(|c| entry[bin(&c.rgb)] = i as u8);
    }
    (palette, rgb.chunks_exact(3).map(|p| entry[bin(p)]).collect())
}

/// Cuts the colours into at most 256 groups of similar ones.
fn cut(colours: Vec<Colour>) -> Vec<Vec<Colour>> {
    let mut boxes = vec![(weight(&colours), colours)];
    while boxes.len() < 256 {
        let widest =
            (0..boxes.len()).max_by(|&a, &b| boxes[a].0.total_cmp(&boxes[b].0)).unwrap_or(0);
        if boxes[widest].0 <= 0.0 {
            break;
        }
        let (_, mut low) = boxes.swap_remove(widest);
        let (axis, _) = extent(&low);
        low.sort_unstable_by_key(|c| c.rgb[axis]);
        let high = low.split_off(low.len() / 2);
        boxes.push((weight(&low), low));
        boxes.push((weight(&high), high));
    }
    boxes.into_iter().map(|(_, members)| members).filter(|m| !m.is_empty()).collect()
}

/// Priority of a group for being split; 0 for a single colour.
fn weight(group: &[Colour]) -> f64 {
    let pixels: f64 = group.iter().map(|c| c.pixels).sum();
    f64::from(extent(group).1).powi(2) * pixels.sqrt()
}

/// The axis along which the colours of a group differ most, and by how much.
fn extent(group: &[Colour]) -> (usize, u8) {
    let along = |k: usize| {
        let (low, high) =
            group.iter().fold((255, 0), |(a, b), c| (c.rgb[k].min(a), c.rgb[k].max(b)));
        (k, high.saturating_sub(low))
    };
    (0..3).map(along).max_by_key(|e| e.1).unwrap_or((0, 0))
}

fn bin(rgb: &[u8]) -> usize {
    rgb.iter().fold(0, |k, &v| k << BITS | usize::from(v >> (8 - BITS)))
}

/// The colour of a bin, with black and white exact.
fn colour(bin: usize) -> [u8; 3] {
    [2, 1, 0].map(|k| {
        let v = (bin >> (k * BITS as usize)) as u8 & ((1 << BITS) - 1);
        v << (8 - BITS) | v >> (2 * BITS - 8)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(rgb: &[u8]) -> u8 {
        let (palette, pixels) = reduce(rgb);
        assert!(palette.len() <= 768 && pixels.len() == rgb.len() / 3);
        let shown = pixels.iter().flat_map(|&i| palette[3 * usize::from(i)..][..3].to_vec());
        shown.zip(rgb).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
    }

    #[test]
    fn few_colours_are_kept() {
        assert!(error(&[0, 0, 0, 255, 255, 255, 12, 200, 99, 12, 200, 99]) <= 3);
        let (palette, pixels) = reduce(&[255, 255, 255, 0, 0, 0]);
        assert_eq!(palette[3 * usize::from(pixels[0])..][..3], [255; 3]);
        assert_eq!(palette[3 * usize::from(pixels[1])..][..3], [0; 3]);
        assert_eq!(reduce(&[]), (vec![], vec![]));
    }

    #[test]
    fn rare_colours_survive_a_sea_of_one() {
        let mut rgb = [68, 1, 84].repeat(400_000);
        for k in 0..=255u8 {
            rgb.extend([k, 255 - k / 2, 128 + k / 3]);
        }
        assert!(error(&rgb) <= 6, "{}", error(&rgb));
    }
}
