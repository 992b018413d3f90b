//! Makes XML as robot programs write it plain enough for a strict reader.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Deepest nesting of XML elements: a recursive reader would overflow its stack.
const XML_DEPTH_MAX: usize = 64;

/// An error in an XML text, and its line, from 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct XmlError {
    pub(crate) line: usize,
    pub(crate) message: String,
}

/// The same text with blanks in place of remarks, declarations and document types, which may stand
/// anywhere, and with prefixes declared that are not. Every element keeps its line.
///
/// # Errors
/// When it is not well formed, or nested too deeply.
pub(crate) fn plain_xml(text: &str) -> Result<String, XmlError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut plain = Plain { text, kept: String::with_capacity(text.len()), ..Plain::default() };
    let mut reader = Reader::from_str(text);
    let complain = |offset: u64, message: String| XmlError {
        line: 1 + text.as_bytes()[..(offset as usize).min(text.len())]
            .iter()
            .filter(|byte| **byte == b'\n')
            .count(),
        message,
    };
    loop {
        let begin = reader.buffer_position();
        let event = reader.read_event().map_err(|error| {
            complain(reader.error_position(), format!("is not well-formed XML: {error}"))
        })?;
        let is_end = matches!(event, Event::Eof);
        let range = begin as usize..reader.buffer_position() as usize;
        plain.take(event, range).map_err(|message| complain(begin, message))?;
        if is_end {
            return Ok(plain.finish());
        }
    }
}

#[derive(Default)]
struct Plain<'a> {
    text: &'a str,
    kept: String,
    depth: usize,
    /// Where in `kept` attributes may be added to the root.
    root_end: Option<usize>,
    declared: Vec<String>,
    used: Vec<String>,
}

impl Plain<'_> {
    fn take(&mut self, event: Event, range: std::ops::Range<usize>) -> Result<(), String> {
        let part = &self.text[range];
        match event {
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) => self.blank(part),
            Event::DocType(_) if part.contains("<!") && part[2..].contains("<!") => {
                return Err("defines entities or attributes in its <!DOCTYPE>; expand them".into());
            }
            Event::DocType(_) => self.blank(part),
            Event::Start(tag) if self.depth == XML_DEPTH_MAX => {
                let _ = tag;
                return Err(format!("its elements are nested deeper than {XML_DEPTH_MAX}"));
            }
            Event::Start(tag) => {
                self.note(&tag);
                self.kept.push_str(part);
                self.depth += 1;
            }
            Event::Empty(tag) => {
                self.note(&tag);
                self.kept.push_str(part);
            }
            Event::End(_) => {
                self.depth = self.depth.saturating_sub(1);
                self.kept.push_str(part);
            }
            _ => self.kept.push_str(part),
        }
        Ok(())
    }

    /// Keeps the line breaks of a part.
    fn blank(&mut self, part: &str) {
        self.kept.extend(part.chars().map(|character| if character == '\n' { '\n' } else { ' ' }));
    }

    /// Notes the prefixes that an element declares and uses.
    fn note(&mut self, tag: &BytesStart) {
        let prefix = |name: &[u8]| {
            let name = String::from_utf8_lossy(name);
            name.split_once(':').map(|(prefix, rest)| (prefix.to_owned(), rest.to_owned()))
        };
        if self.root_end.is_none() {
            self.root_end = Some(self.kept.len() + 1 + tag.name().as_ref().len());
        }
        self.used.extend(prefix(tag.name().as_ref()).map(|(used, _)| used));
        for attribute in tag.attributes().with_checks(false).flatten() {
            match prefix(attribute.key.as_ref()) {
                Some((xmlns, declared)) if xmlns == "xmlns" => self.declared.push(declared),
                Some((used, _)) => self.used.push(used),
                None => {}
            }
        }
    }

    fn finish(mut self) -> String {
        self.used.sort();
        self.used.dedup();
        let Self { kept, used, declared, root_end, .. } = &mut self;
        used.retain(|prefix| prefix != "xml" && !declared.contains(prefix));
        if let Some(at) = *root_end {
            for prefix in used.iter() {
                kept.insert_str(at, &format!(" xmlns:{prefix}=\"undeclared:{prefix}\""));
            }
        }
        self.kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_robot_programs_write_becomes_plain_and_keeps_its_lines() {
        let text = "\n<!-- a -- b\n --><?xml version=\"1.0\"?><!DOCTYPE robot>\n<robot>\n<sim:a b:c=\"1\"/><!-- - --- - --></robot>\n";
        let plain = plain_xml(text).unwrap();
        let document = roxmltree::Document::parse(&plain).unwrap();
        let child = document.root_element().first_element_child().unwrap();
        assert_eq!(child.tag_name().name(), "a");
        assert_eq!(document.text_pos_at(child.range().start).row, 5);
    }

    #[test]
    fn entities_depth_and_damage_are_refused_with_their_line() {
        let message = |text: &str| plain_xml(text).unwrap_err();
        let dtd = message("<!DOCTYPE robot [<!ENTITY a \"b\">]>\n<robot>&a;</robot>");
        assert!(dtd.line == 1 && dtd.message.contains("entities"), "{dtd:?}");
        let deep = message(&("\n".to_owned() + &"<a>".repeat(65)));
        assert!(deep.line == 2 && deep.message.contains("nested deeper"), "{deep:?}");
        let open = message("<a>\n</b>");
        assert_eq!(open.line, 2, "{open:?}");
    }
}
