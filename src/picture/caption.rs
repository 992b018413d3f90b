//! Words on a finished picture: what it shows, the time at which the robot is where, and the scale.

use embedded_graphics::mono_font::iso_8859_1::{FONT_8X13, FONT_10X20};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};

use crate::picture::output::Image;

/// Rows from which on a picture takes the larger letters.
const LARGE_ROWS: usize = 600;
/// The distance of text from the picture's border, pixels.
const BORDER: i32 = 12;
const INK: Rgb888 = Rgb888::new(0x1b, 0x24, 0x30);
/// Around the ink, so that letters are legible on any body.
const HALO: Rgb888 = Rgb888::new(0xf4, 0xf6, 0xf9);

impl OriginDimensions for Image {
    fn size(&self) -> Size {
        Size::new(self.size.width as u32, self.size.height as u32)
    }
}

impl DrawTarget for Image {
    type Color = Rgb888;
    type Error = std::convert::Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Self::Error> {
        let (width, height) = (self.size.width, self.size.height);
        for Pixel(at, colour) in pixels {
            let (Ok(column), Ok(row)) = (usize::try_from(at.x), usize::try_from(at.y)) else {
                continue;
            };
            if column < width && row < height {
                let first = 3 * (row * width + column);
                let bytes = [colour.r(), colour.g(), colour.b()];
                self.bytes[first..first + 3].copy_from_slice(&bytes);
            }
        }
        Ok(())
    }
}

/// Writes lines into the lower left corner.
pub(crate) fn write_title(image: &mut Image, lines: &[String]) {
    let line_height = font(image).character_size.height as i32 + 2;
    let bottom = image.size.height as i32 - BORDER;
    for (index, line) in lines.iter().rev().enumerate() {
        let corner = Point::new(BORDER, bottom - index as i32 * line_height);
        write(image, line, corner, (Alignment::Left, Baseline::Bottom));
    }
}

/// Writes a line into the lower right corner.
pub(crate) fn write_scale(image: &mut Image, line: &str) {
    let [width, height] = [image.size.width, image.size.height].map(|side| side as i32);
    let corner = Point::new(width - BORDER, height - BORDER);
    write(image, line, corner, (Alignment::Right, Baseline::Bottom));
}

/// Writes a word centred above a pixel.
pub(crate) fn write_label(image: &mut Image, word: &str, [column, row]: [f64; 2]) {
    let above = Point::new(column.round() as i32, row.round() as i32);
    write(image, word, above, (Alignment::Center, Baseline::Bottom));
}

fn write(image: &mut Image, text: &str, at: Point, (alignment, baseline): (Alignment, Baseline)) {
    let layout = TextStyleBuilder::new().alignment(alignment).baseline(baseline).build();
    let font = font(image);
    let mut draw = |at: Point, colour: Rgb888| {
        let letters = MonoTextStyle::new(font, colour);
        // An image takes every pixel.
        let _ = Text::with_text_style(text, at, letters, layout).draw(image);
    };
    for (x, y) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
        draw(at + Point::new(x, y), HALO);
    }
    draw(at, INK);
}

fn font(image: &Image) -> &'static MonoFont<'static> {
    if image.size.height >= LARGE_ROWS { &FONT_10X20 } else { &FONT_8X13 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::camera;

    fn blank() -> Image {
        let size = camera::Size { width: 200, height: 60 };
        Image { size, bytes: vec![128; 3 * size.pixels()] }
    }

    /// Columns and rows of the pixels that have the colour of ink.
    fn inked(image: &Image) -> Vec<(usize, usize)> {
        let is_ink = |pixel: &[u8]| pixel == [INK.r(), INK.g(), INK.b()];
        let pixels = image.bytes.chunks_exact(3).enumerate();
        let place = |index| (index % image.size.width, index / image.size.width);
        pixels.filter(|(_, pixel)| is_ink(pixel)).map(|(index, _)| place(index)).collect()
    }

    #[test]
    fn titles_begin_at_the_left_border_and_scales_end_at_the_right_one() {
        let (mut title, mut scale) = (blank(), blank());
        write_title(&mut title, &["H".to_owned()]);
        write_scale(&mut scale, "H");
        let [title, scale] = [inked(&title), inked(&scale)];
        let border = BORDER as usize;
        assert!(!title.is_empty() && title.len() == scale.len());
        let rows = 47 - border..60 - border;
        let is_left = |&(column, row): &(usize, usize)| {
            (border..border + 8).contains(&column) && rows.contains(&row)
        };
        let is_right = |&(column, row): &(usize, usize)| {
            (192 - border..200 - border).contains(&column) && rows.contains(&row)
        };
        assert!(title.iter().all(is_left) && scale.iter().all(is_right), "{title:?} {scale:?}");
    }

    #[test]
    fn a_label_beyond_the_picture_is_cut() {
        let mut image = blank();
        write_label(&mut image, "12.3 s", [0.0, 2.0]);
        write_label(&mut image, "12.3 s", [-1e9, 1e9]);
        assert!(inked(&image).iter().all(|&(column, row)| column < 32 && row < 2));
    }
}
