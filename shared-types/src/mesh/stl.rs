//! Reads STL files, binary and text.
//!
//! A reader of its own because files differ in what libraries do not take: capitals, missing or
//! foreign names, several solids, a binary header that begins with "solid", zeros at the end.

use glam::DVec3;

use crate::base::text_file::plain_lines;
use crate::mesh::raw_mesh::{MeshError, Welder};

/// Bytes before the count of a binary file.
const HEADER_BYTES: usize = 80;
/// Bytes before the triangles of a binary file.
const PREAMBLE_BYTES: usize = HEADER_BYTES + 4;
/// Bytes of a triangle: normal, three corners, two bytes for attributes.
const TRIANGLE_BYTES: usize = 50;

/// Reads a file. CAD exporters write 80 bytes for a part without a body: no triangles.
pub(crate) fn read(bytes: &[u8], welder: &mut Welder) -> Result<(), MeshError> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let is_text = is_text(text) && !bytes.contains(&0);
    let is_stub = bytes.len() == HEADER_BYTES
        && !bytes.windows(5).any(|word| word.eq_ignore_ascii_case(b"facet"));
    match (is_stub, is_text) {
        (true, _) => Ok(()),
        (_, true) => read_text(&plain_lines(&String::from_utf8_lossy(text)), welder),
        (_, false) => {
            read_binary(bytes, welder).map_err(|error| other_text(bytes).unwrap_or(error))
        }
    }
}

/// Whether a file begins as a text does. The header of a binary one may do so as well.
pub(crate) fn is_text(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

/// The complaint about a file that cannot be read as binary and is text, or nothing.
fn other_text(bytes: &[u8]) -> Option<MeshError> {
    let is_text = std::str::from_utf8(bytes).is_ok() && !bytes.contains(&0);
    is_text.then(|| "is text that does not begin with 'solid': no STL file; export it again".into())
}

fn read_binary(bytes: &[u8], welder: &mut Welder) -> Result<(), MeshError> {
    let (Some(count), Some(body)) =
        (bytes.get(HEADER_BYTES..PREAMBLE_BYTES), bytes.get(PREAMBLE_BYTES..))
    else {
        return Err(format!("is no STL file: it has {} bytes", bytes.len()).into());
    };
    let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize;
    if body.len() / TRIANGLE_BYTES < count {
        return Err(format!(
            "says that it holds {count} triangles, but has bytes for {} only; copy or export it again",
            body.len() / TRIANGLE_BYTES
        )
        .into());
    }
    let (triangles, rest) = body.split_at(count * TRIANGLE_BYTES);
    // Zeros are no triangle with area: some exporters fill up a block with them.
    if rest.iter().any(|byte| *byte != 0 && !byte.is_ascii_whitespace()) {
        return Err(format!(
            "says that it holds {count} triangles, but {} bytes follow them; export it again",
            rest.len()
        )
        .into());
    }
    for triangle in triangles.chunks_exact(TRIANGLE_BYTES) {
        let number = |at: usize| {
            let bytes = [0, 1, 2, 3].map(|byte| triangle[12 + 4 * at + byte]);
            f64::from(f32::from_le_bytes(bytes))
        };
        welder.push([0, 3, 6].map(|at| DVec3::new(number(at), number(at + 1), number(at + 2))))?;
    }
    Ok(())
}

/// Reads solids, one after the other, until the end.
fn read_text(text: &str, welder: &mut Welder) -> Result<(), MeshError> {
    let mut words = Tokens::new(text);
    while words.peek().is_some() {
        words.expect("solid")?;
        words.skip_name()?;
        loop {
            let word = words.keyword()?;
            match word.as_str() {
                "facet" => {
                    welder.push(facet(&mut words)?).map_err(|message| words.error(message))?
                }
                "endsolid" => break,
                _ => return Err(words.unexpected(&word, "facet or endsolid")),
            }
        }
        words.skip_name()?;
    }
    Ok(())
}

/// The corners of a facet, from behind the word.
fn facet(words: &mut Tokens) -> Result<[DVec3; 3], MeshError> {
    words.expect("normal")?;
    // Normals follow from the corners; some exporters write words for theirs.
    (0..3).try_for_each(|_| words.next_token().map(|_| ()))?;
    words.expect("outer")?;
    words.expect("loop")?;
    let mut corners = [DVec3::ZERO; 3];
    for corner in &mut corners {
        words.expect("vertex")?;
        *corner = DVec3::new(words.number()?, words.number()?, words.number()?);
    }
    words.expect("endloop")?;
    words.expect("endfacet")?;
    Ok(corners)
}

/// The words of a text, with the line of the last one.
struct Tokens<'a> {
    lines: std::str::Lines<'a>,
    words: std::str::SplitWhitespace<'a>,
    line: usize,
    ahead: Option<&'a str>,
}

impl<'a> Tokens<'a> {
    fn new(text: &'a str) -> Self {
        Self { lines: text.lines(), words: "".split_whitespace(), line: 0, ahead: None }
    }

    fn next(&mut self) -> Option<&'a str> {
        if let Some(word) = self.ahead.take() {
            return Some(word);
        }
        loop {
            if let Some(word) = self.words.next() {
                return Some(word);
            }
            self.words = self.lines.next()?.split_whitespace();
            self.line += 1;
        }
    }

    fn peek(&mut self) -> Option<&'a str> {
        self.ahead = self.next();
        self.ahead
    }

    /// Passes over the rest of the line: the name of a solid.
    fn skip_name(&mut self) -> Result<(), MeshError> {
        match self.words.find(|word| word.to_ascii_lowercase().ends_with("facet")) {
            Some(word) => Err(self.unexpected(word, "the name of a solid")),
            None => Ok(()),
        }
    }

    fn next_token(&mut self) -> Result<&'a str, MeshError> {
        let end = "ends within a solid, as if it were cut; copy or export it again";
        self.next().ok_or_else(|| self.error(end.into()))
    }

    /// A word in small letters; "end" is one with the word that follows it.
    fn keyword(&mut self) -> Result<String, MeshError> {
        let word = self.next_token()?.to_ascii_lowercase();
        Ok(if word == "end" { word + &self.next_token()?.to_ascii_lowercase() } else { word })
    }

    fn expect(&mut self, wanted: &str) -> Result<(), MeshError> {
        match self.keyword()? {
            word if word == wanted => Ok(()),
            word => Err(self.unexpected(&word, wanted)),
        }
    }

    fn number(&mut self) -> Result<f64, MeshError> {
        let word = self.next_token()?;
        let number: Result<f32, _> = word.parse();
        number.map(f64::from).map_err(|_| self.unexpected(word, "a number"))
    }

    fn unexpected(&self, word: &str, wanted: &str) -> MeshError {
        let word: String = word.chars().take(24).collect();
        self.error(format!("has '{word}' where {wanted} belongs; export it again"))
    }

    fn error(&self, message: String) -> MeshError {
        MeshError::at(self.line, message)
    }
}
