//! Reads MCAP files, checking every length, checksum, index and count against the format's
//! definition.

use std::collections::BTreeMap;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// A message.
pub struct Message {
    pub channel: u16,
    pub time: u64,
    pub data: Vec<u8>,
}

/// The content of a file.
#[derive(Default)]
pub struct McapFile {
    pub profile: String,
    /// Name and definition, by number.
    pub schemas: BTreeMap<u16, (String, String)>,
    /// Topic and schema, by number.
    pub channels: BTreeMap<u16, (String, u16)>,
    pub metadata: BTreeMap<String, String>,
    pub messages: Vec<Message>,
    /// Time, offset within the chunk and chunk of each message, by channel.
    places: BTreeMap<u16, Vec<(u64, u64)>>,
}

/// Bytes that are read from the front.
#[derive(Clone, Copy)]
pub struct Bytes<'a>(pub &'a [u8]);

impl<'a> Bytes<'a> {
    pub fn take(&mut self, count: usize) -> &'a [u8] {
        let (head, tail) = self.0.split_at(count);
        self.0 = tail;
        head
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.take(2).try_into().unwrap())
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take(4).try_into().unwrap())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take(8).try_into().unwrap())
    }

    fn sized(&mut self) -> Bytes<'a> {
        let length = self.u32() as usize;
        Bytes(self.take(length))
    }

    fn text(&mut self) -> String {
        String::from_utf8(self.sized().0.to_vec()).unwrap()
    }

    fn record(&mut self) -> (u8, Bytes<'a>) {
        let opcode = self.take(1)[0];
        let length = self.u64() as usize;
        (opcode, Bytes(self.take(length)))
    }
}

impl McapFile {
    /// Reads a file.
    pub fn read(bytes: &[u8]) -> Self {
        let mut file = Self::default();
        let mut rest = Bytes(bytes);
        assert_eq!(rest.take(MAGIC.len()), MAGIC);
        loop {
            let at = bytes.len() - rest.0.len();
            let (opcode, mut content) = rest.record();
            match opcode {
                0x01 => file.profile = content.text(),
                0x06 => file.chunk(content),
                0x07 => file.message_index(content),
                0x0f => {
                    assert_eq!(content.u32(), crc32fast::hash(&bytes[..at]));
                    break;
                }
                _ => file.declaration(opcode, content),
            }
        }
        let indexed: usize = file.places.values().map(Vec::len).sum();
        assert_eq!(indexed, file.messages.len());
        file.summary(bytes, bytes.len() - rest.0.len());
        file
    }

    /// The number of a topic's channel, and its schema's name and definition.
    pub fn channel(&self, topic: &str) -> (u16, (String, String)) {
        let found = self.channels.iter().find(|(_, (other, _))| other == topic).unwrap();
        (*found.0, self.schemas[&found.1.1].clone())
    }

    fn declaration(&mut self, opcode: u8, mut content: Bytes<'_>) {
        match opcode {
            0x03 => {
                let (id, name, encoding) = (content.u16(), content.text(), content.text());
                assert_eq!(encoding, "ros2msg");
                self.schemas.insert(id, (name, content.text()));
            }
            0x04 => {
                let (id, schema, topic) = (content.u16(), content.u16(), content.text());
                assert!(self.schemas.contains_key(&schema) && content.text() == "cdr");
                self.channels.insert(id, (topic, schema));
            }
            0x0c => {
                assert_eq!(content.text(), "surefoot");
                let mut entries = content.sized();
                while !entries.0.is_empty() {
                    self.metadata.insert(entries.text(), entries.text());
                }
            }
            other => panic!("record {other:#x} among the data"),
        }
    }

    fn chunk(&mut self, mut content: Bytes<'_>) {
        let (first, last, size, checksum) =
            (content.u64(), content.u64(), content.u64(), content.u32());
        assert_eq!(content.text(), "");
        assert_eq!(content.u64(), size);
        let mut records = content;
        assert_eq!((records.0.len() as u64, crc32fast::hash(records.0)), (size, checksum));
        while !records.0.is_empty() {
            let (opcode, mut message) = records.record();
            assert_eq!(opcode, 0x05);
            let (channel, sequence, time) = (message.u16(), message.u32(), message.u64());
            assert!(message.u64() == time && (first..=last).contains(&time));
            let same = |other: &&Message| other.channel == channel;
            assert_eq!(self.messages.iter().filter(same).count(), sequence as usize);
            assert!(self.channels.contains_key(&channel));
            self.messages.push(Message { channel, time, data: message.0.to_vec() });
        }
    }

    fn message_index(&mut self, mut content: Bytes<'_>) {
        let channel = content.u16();
        let mut entries = content.sized();
        while !entries.0.is_empty() {
            self.places.entry(channel).or_default().push((entries.u64(), entries.u64()));
        }
    }

    /// Checks the summary, which begins at `begin`.
    fn summary(&self, bytes: &[u8], begin: usize) {
        let mut rest = Bytes(&bytes[begin..]);
        let (mut chunks, mut counted) = (0, 0);
        loop {
            let at = bytes.len() - rest.0.len();
            let (opcode, mut content) = rest.record();
            match opcode {
                0x08 => {
                    let (_, _, start) = (content.u64(), content.u64(), content.u64());
                    assert_eq!(bytes[start as usize], 0x06);
                    chunks += 1;
                }
                0x0b => {
                    counted = content.u64();
                    assert_eq!(content.u16() as usize, self.schemas.len());
                    assert_eq!(content.u32() as usize, self.channels.len());
                    assert_eq!((content.u32(), content.u32()), (0, 1));
                    assert_eq!(content.u32(), chunks);
                }
                0x02 => {
                    assert_eq!((content.u64(), content.u64()), (begin as u64, 0));
                    let end = at + 1 + 8 + 16;
                    assert_eq!(content.u32(), crc32fast::hash(&bytes[begin..end]));
                    break;
                }
                other => assert!([0x03, 0x04, 0x0d].contains(&other), "record {other:#x}"),
            }
        }
        assert_eq!(rest.0, MAGIC);
        assert_eq!(counted as usize, self.messages.len());
    }
}
