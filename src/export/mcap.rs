//! MCAP files, version 0: schemas, channels and messages in uncompressed chunks, each with an
//! index, and a summary at the end, so that viewers find every instant without reading the whole
//! file.

use std::collections::BTreeMap;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// A chunk ends when it holds this many bytes.
const CHUNK_BYTES: usize = 1 << 20;
/// Length of a footer: two offsets and a checksum, bytes.
const FOOTER_BYTES: u64 = 8 + 8 + 4;

/// The kinds of records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
enum Opcode {
    Header = 0x01,
    Footer = 0x02,
    Schema = 0x03,
    Channel = 0x04,
    Message = 0x05,
    Chunk = 0x06,
    MessageIndex = 0x07,
    ChunkIndex = 0x08,
    Statistics = 0x0b,
    Metadata = 0x0c,
    MetadataIndex = 0x0d,
    DataEnd = 0x0f,
}

/// A file in the making. Messages are to be written in the order of their times.
#[derive(Debug)]
pub struct McapWriter {
    bytes: Vec<u8>,
    /// Schemas and channels, which the summary repeats.
    declarations: Vec<u8>,
    schemas: u16,
    channels: u16,
    chunk: Chunk,
    /// The indexes of chunks and metadata.
    indexes: Vec<u8>,
    chunks: u32,
    metadata: u32,
    /// The number of messages by channel.
    counts: BTreeMap<u16, u64>,
    span: Option<(u64, u64)>,
}

/// The messages that are not in the file yet.
#[derive(Debug, Default)]
struct Chunk {
    records: Vec<u8>,
    /// Time and offset of each message, by channel.
    index: BTreeMap<u16, Vec<(u64, u64)>>,
    span: Option<(u64, u64)>,
}

/// Appends numbers and texts as records hold them.
trait Fields {
    fn text(&mut self, text: &str);
    fn sized(&mut self, content: &[u8]);
    fn record(&mut self, opcode: Opcode, content: &[u8]);
}

impl Fields for Vec<u8> {
    fn text(&mut self, text: &str) {
        self.sized(text.as_bytes());
    }

    /// Content after its 32-bit length.
    fn sized(&mut self, content: &[u8]) {
        self.extend((content.len() as u32).to_le_bytes());
        self.extend(content);
    }

    fn record(&mut self, opcode: Opcode, content: &[u8]) {
        self.push(opcode as u8);
        self.extend((content.len() as u64).to_le_bytes());
        self.extend(content);
    }
}

fn wider(span: Option<(u64, u64)>, time: u64) -> Option<(u64, u64)> {
    let (first, last) = span.unwrap_or((time, time));
    Some((first.min(time), last.max(time)))
}

impl McapWriter {
    /// A file of ROS 2 messages by `library`.
    pub fn new(library: &str) -> Self {
        let mut bytes = MAGIC.to_vec();
        let mut header = Vec::new();
        header.text("ros2");
        header.text(library);
        bytes.record(Opcode::Header, &header);
        Self {
            bytes,
            declarations: Vec::new(),
            schemas: 0,
            channels: 0,
            chunk: Chunk::default(),
            indexes: Vec::new(),
            chunks: 0,
            metadata: 0,
            counts: BTreeMap::new(),
            span: None,
        }
    }

    /// Declares a schema of the encoding `ros2msg`; its number.
    pub fn schema(&mut self, name: &str, definition: &str) -> u16 {
        self.schemas += 1;
        let mut content = self.schemas.to_le_bytes().to_vec();
        content.text(name);
        content.text("ros2msg");
        content.sized(definition.as_bytes());
        self.declare(Opcode::Schema, &content);
        self.schemas
    }

    /// Declares a channel of messages of a schema in CDR; its number.
    pub fn channel(&mut self, schema: u16, topic: &str) -> u16 {
        self.channels += 1;
        let mut content = self.channels.to_le_bytes().to_vec();
        content.extend(schema.to_le_bytes());
        content.text(topic);
        content.text("cdr");
        // No metadata.
        content.sized(&[]);
        self.declare(Opcode::Channel, &content);
        self.channels
    }

    fn declare(&mut self, opcode: Opcode, content: &[u8]) {
        self.bytes.record(opcode, content);
        self.declarations.record(opcode, content);
    }

    /// Writes names and values.
    pub fn metadata(&mut self, name: &str, values: &BTreeMap<&str, String>) {
        self.flush();
        let mut entries = Vec::new();
        for (key, value) in values {
            entries.text(key);
            entries.text(value);
        }
        let mut content = Vec::new();
        content.text(name);
        content.sized(&entries);
        let at = self.bytes.len();
        self.bytes.record(Opcode::Metadata, &content);
        let mut index = (at as u64).to_le_bytes().to_vec();
        index.extend(((self.bytes.len() - at) as u64).to_le_bytes());
        index.text(name);
        self.indexes.record(Opcode::MetadataIndex, &index);
        self.metadata += 1;
    }

    /// Writes a message at a time, ns.
    pub fn message(&mut self, channel: u16, time: u64, data: &[u8]) {
        let count = self.counts.entry(channel).or_default();
        let mut content = channel.to_le_bytes().to_vec();
        content.extend((*count as u32).to_le_bytes());
        // When it was recorded, and when it was published.
        content.extend(time.to_le_bytes());
        content.extend(time.to_le_bytes());
        content.extend(data);
        *count += 1;
        let at = self.chunk.records.len() as u64;
        self.chunk.index.entry(channel).or_default().push((time, at));
        self.chunk.records.record(Opcode::Message, &content);
        self.chunk.span = wider(self.chunk.span, time);
        self.span = wider(self.span, time);
        if self.chunk.records.len() >= CHUNK_BYTES {
            self.flush();
        }
    }

    /// Writes the chunk that is collected, and its indexes.
    fn flush(&mut self) {
        let Chunk { records, index, span } = std::mem::take(&mut self.chunk);
        let Some((first, last)) = span else { return };
        let size = (records.len() as u64).to_le_bytes();
        let span = [first.to_le_bytes(), last.to_le_bytes()].concat();
        let mut content = span.clone();
        content.extend(size);
        content.extend(crc32fast::hash(&records).to_le_bytes());
        content.text("");
        content.extend(size);
        content.extend(&records);
        let start = self.bytes.len() as u64;
        self.bytes.record(Opcode::Chunk, &content);
        let end = self.bytes.len() as u64;
        let mut offsets = Vec::new();
        for (channel, messages) in index {
            offsets.extend(channel.to_le_bytes());
            offsets.extend((self.bytes.len() as u64).to_le_bytes());
            let numbers = messages.iter().flat_map(|&(time, at)| [time, at]);
            let entries: Vec<u8> = numbers.flat_map(u64::to_le_bytes).collect();
            let mut content = channel.to_le_bytes().to_vec();
            content.sized(&entries);
            self.bytes.record(Opcode::MessageIndex, &content);
        }
        let mut content = span;
        content.extend(start.to_le_bytes());
        content.extend((end - start).to_le_bytes());
        content.sized(&offsets);
        content.extend((self.bytes.len() as u64 - end).to_le_bytes());
        content.text("");
        content.extend(size);
        content.extend(size);
        self.indexes.record(Opcode::ChunkIndex, &content);
        self.chunks += 1;
    }

    fn statistics(&self) -> Vec<u8> {
        let (first, last) = self.span.unwrap_or((0, 0));
        let messages: u64 = self.counts.values().sum();
        let mut content = messages.to_le_bytes().to_vec();
        content.extend(self.schemas.to_le_bytes());
        // Channels, attachments, metadata, chunks.
        for number in [u32::from(self.channels), 0, self.metadata, self.chunks] {
            content.extend(number.to_le_bytes());
        }
        content.extend(first.to_le_bytes());
        content.extend(last.to_le_bytes());
        let mut counts = Vec::new();
        for (channel, count) in &self.counts {
            counts.extend(channel.to_le_bytes());
            counts.extend(count.to_le_bytes());
        }
        content.sized(&counts);
        content
    }

    /// The complete file.
    pub fn finish(mut self) -> Vec<u8> {
        self.flush();
        let checksum = crc32fast::hash(&self.bytes);
        self.bytes.record(Opcode::DataEnd, &checksum.to_le_bytes());
        let summary = self.bytes.len();
        let statistics = self.statistics();
        self.bytes.extend(&self.declarations);
        self.bytes.extend(&self.indexes);
        self.bytes.record(Opcode::Statistics, &statistics);
        // Where the summary begins; there are no offsets of its groups.
        self.bytes.push(Opcode::Footer as u8);
        self.bytes.extend(FOOTER_BYTES.to_le_bytes());
        self.bytes.extend((summary as u64).to_le_bytes());
        self.bytes.extend(0_u64.to_le_bytes());
        let checksum = crc32fast::hash(&self.bytes[summary..]);
        self.bytes.extend(checksum.to_le_bytes());
        self.bytes.extend(MAGIC);
        self.bytes
    }
}
