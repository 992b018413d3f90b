//! PNG and APNG files, complete or not at all.

use std::path::Path;

use png::{BitDepth, BlendOp, ColorType, Compression, DisposeOp, Encoder, EncodingError, Filter};

use surefoot_shared_types::base::whole_file;

use crate::picture::camera::Size;
use crate::picture::error::PictureError;
use crate::system::signals;

/// A finished picture: sRGB, three bytes a pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Its size.
    pub size: Size,
    /// Rows from the top.
    pub bytes: Vec<u8>,
}

/// Frames a second of a moving picture.
const FRAME_RATE: u16 = 15;
/// How long the last frame stays, in frames.
const LAST_FRAME_HOLD: u16 = 24;

/// Writes one picture.
pub fn write_png(image: &Image, path: &Path) -> Result<(), PictureError> {
    replace(path, |file| {
        let mut writer = encoder(file, image.size, Compression::High).write_header()?;
        writer.write_image_data(&image.bytes)?;
        writer.finish()
    })
}

/// Writes a moving picture that repeats forever. Frames after the first hold only what changed.
/// There is at least one frame, all of one size.
pub fn write_apng(frames: &[Image], path: &Path) -> Result<(), PictureError> {
    replace(path, |file| {
        let mut encoder = encoder(file, frames[0].size, Compression::Balanced);
        encoder.set_animated(frames.len() as u32, 0)?;
        encoder.set_blend_op(BlendOp::Source)?;
        encoder.set_dispose_op(DisposeOp::None)?;
        let mut writer = encoder.write_header()?;
        for (index, frame) in frames.iter().enumerate() {
            let change = if index == 0 {
                Patch::whole(frame)
            } else {
                Patch::between(&frames[index - 1], frame)
            };
            let delay = if index + 1 == frames.len() { LAST_FRAME_HOLD } else { 1 };
            writer.set_frame_delay(delay, FRAME_RATE)?;
            writer.reset_frame_position()?;
            writer.set_frame_dimension(change.size.width as u32, change.size.height as u32)?;
            writer.set_frame_position(change.column as u32, change.row as u32)?;
            writer.write_image_data(&change.bytes(frame))?;
        }
        writer.finish()
    })
}

fn encoder<W: std::io::Write>(
    file: W,
    size: Size,
    compression: Compression,
) -> Encoder<'static, W> {
    let mut encoder = Encoder::new(file, size.width as u32, size.height as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(compression);
    encoder.set_filter(Filter::Adaptive);
    encoder
}

/// Draws into memory and writes the whole file.
fn replace(
    path: &Path,
    write: impl FnOnce(&mut Vec<u8>) -> Result<(), EncodingError>,
) -> Result<(), PictureError> {
    let failed = |reason: String| PictureError::Write { path: path.to_owned(), reason };
    let mut bytes = Vec::new();
    write(&mut bytes).map_err(|error| failed(error.to_string()))?;
    let _deferral = signals::defer();
    whole_file::write(path, &bytes).map_err(failed)
}

/// A rectangle of a picture.
struct Patch {
    column: usize,
    row: usize,
    size: Size,
}

impl Patch {
    fn whole(frame: &Image) -> Self {
        Self { column: 0, row: 0, size: frame.size }
    }

    /// The smallest rectangle outside which two pictures are equal; one pixel if they are equal
    /// everywhere.
    fn between(before: &Image, after: &Image) -> Self {
        let width = after.size.width;
        let pixels = before.bytes.chunks_exact(3).zip(after.bytes.chunks_exact(3)).enumerate();
        let changed =
            pixels.filter(|(_, (a, b))| a != b).map(|(index, _)| (index % width, index / width));
        let (low, high) = changed.fold(([usize::MAX; 2], [0; 2]), |(low, high), (column, row)| {
            ([low[0].min(column), low[1].min(row)], [high[0].max(column), high[1].max(row)])
        });
        if low[0] == usize::MAX {
            return Self { column: 0, row: 0, size: Size { width: 1, height: 1 } };
        }
        Self {
            column: low[0],
            row: low[1],
            size: Size { width: high[0] - low[0] + 1, height: high[1] - low[1] + 1 },
        }
    }

    fn bytes(&self, frame: &Image) -> Vec<u8> {
        let rows =
            frame.bytes.chunks_exact(3 * frame.size.width).skip(self.row).take(self.size.height);
        rows.flat_map(|row| &row[3 * self.column..3 * (self.column + self.size.width)])
            .copied()
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    const SIZE: Size = Size { width: 6, height: 4 };

    fn image(dots: &[usize]) -> Image {
        let mut bytes = vec![7; 3 * SIZE.pixels()];
        dots.iter().for_each(|dot| bytes[3 * dot] = 200);
        Image { size: SIZE, bytes }
    }

    #[test]
    fn a_patch_is_the_smallest_change() {
        let patch = Patch::between(&image(&[]), &image(&[8, 15]));
        assert_eq!((patch.column, patch.row, patch.size), (2, 1, Size { width: 2, height: 2 }));
        assert_eq!(patch.bytes(&image(&[8, 15])).len(), 12);
    }

    #[test]
    fn a_moving_picture_plays_back_as_it_was_given() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.apng");
        let frames = [image(&[0]), image(&[9, 22]), image(&[9, 22]), image(&[23])];
        write_apng(&frames, &path).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(File::open(&path).unwrap()))
            .read_info()
            .unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 4);
        let mut shown = image(&[]);
        for frame in &frames {
            let mut data = vec![0; reader.output_buffer_size().unwrap()];
            let info = reader.next_frame(&mut data).unwrap();
            let control = *reader.info().frame_control().unwrap();
            for row in 0..info.height as usize {
                let to = 3
                    * ((control.y_offset as usize + row) * SIZE.width + control.x_offset as usize);
                let line = 3 * info.width as usize;
                shown.bytes[to..to + line]
                    .copy_from_slice(&data[row * info.line_size..row * info.line_size + line]);
            }
            assert_eq!(&shown, frame);
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn no_folder_is_an_error_that_names_the_file() {
        let error = write_png(&image(&[]), Path::new("/no/such/folder/a.png")).unwrap_err();
        assert!(error.to_string().contains("/no/such/folder/a.png"));
    }
}
