//! An MCAP file under way: topics with their schemas, and messages with strictly increasing time stamps on each.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Seek};
use std::path::{Path, PathBuf};

use foxglove::Encode;
use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};
use serde::Serialize;

use crate::DataError;
use crate::atomic_file::{PendingFile, write_atomically};

/// The file. Until it is complete it has no name, so that nothing is left of it however the program ends.
pub(super) struct LogFile {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    buffer: Vec<u8>,
}

/// A topic of the file.
pub(super) struct Topic {
    name: String,
    channel_id: u16,
    sequence: u32,
    last_nanos: Option<i64>,
}

impl LogFile {
    pub(super) fn create(path: &Path) -> Result<Self, DataError> {
        // Says at once whether the log can be put in place later.
        drop(PendingFile::create(path)?);
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let file = tempfile::tempfile_in(folder).map_err(|source| DataError::io(path, source))?;
        // Chunks stay uncompressed: the usual compressors are C libraries.
        let options = WriteOptions::new().compression(None);
        let writer = options.create(BufWriter::new(file)).map_err(|fault| from_mcap(path, fault))?;
        Ok(Self { path: path.to_owned(), writer, buffer: Vec::new() })
    }

    /// Adds a topic of messages in one of Foxglove's schemas.
    pub(super) fn add_topic<M: Encode>(&mut self, name: &str) -> Result<Topic, DataError> {
        let schema =
            M::get_schema().ok_or_else(|| DataError::invalid(&self.path, format!("{name} has no schema")))?;
        self.add(name, &schema.name, &schema.encoding, &schema.data, &M::get_message_encoding())
    }

    /// Adds a topic of JSON objects; `numbers` are those of its keys that a viewer may plot.
    pub(super) fn add_json_topic(
        &mut self,
        name: &str,
        schema_name: &str,
        numbers: &[&str],
    ) -> Result<Topic, DataError> {
        let properties: serde_json::Map<_, _> =
            numbers.iter().map(|key| ((*key).to_owned(), serde_json::json!({"type": "number"}))).collect();
        let schema = serde_json::json!({"title": schema_name, "type": "object", "properties": properties});
        self.add(name, schema_name, "jsonschema", schema.to_string().as_bytes(), "json")
    }

    fn add(
        &mut self,
        name: &str,
        schema_name: &str,
        schema_encoding: &str,
        schema: &[u8],
        message_encoding: &str,
    ) -> Result<Topic, DataError> {
        let schema_id = self.writer.add_schema(schema_name, schema_encoding, schema);
        let channel_id =
            schema_id.and_then(|id| self.writer.add_channel(id, name, message_encoding, &BTreeMap::new()));
        let channel_id = channel_id.map_err(|fault| from_mcap(&self.path, fault))?;
        Ok(Topic { name: name.to_owned(), channel_id, sequence: 0, last_nanos: None })
    }

    /// Appends a message in one of Foxglove's schemas.
    pub(super) fn log<M: Encode>(
        &mut self,
        topic: &mut Topic,
        time_nanos: i64,
        message: &M,
    ) -> Result<(), DataError> {
        self.buffer.clear();
        message.encode(&mut self.buffer).map_err(|fault| self.cannot_encode(topic, &fault))?;
        self.append(topic, time_nanos)
    }

    /// Appends a JSON message.
    pub(super) fn log_json<M: Serialize>(
        &mut self,
        topic: &mut Topic,
        time_nanos: i64,
        message: &M,
    ) -> Result<(), DataError> {
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, message)
            .map_err(|fault| self.cannot_encode(topic, &fault))?;
        self.append(topic, time_nanos)
    }

    /// Completes the file and puts it in place.
    pub(super) fn finish(mut self) -> Result<(), DataError> {
        self.writer.finish().map_err(|fault| from_mcap(&self.path, fault))?;
        let io = |source| DataError::io(&self.path, source);
        let mut file = self.writer.into_inner().into_inner().map_err(|failed| io(failed.into_error()))?;
        file.rewind().map_err(io)?;
        write_atomically(&self.path, |out| std::io::copy(&mut file, out).map(drop))
    }

    fn append(&mut self, topic: &mut Topic, time_nanos: i64) -> Result<(), DataError> {
        let earlier = topic.last_nanos.is_some_and(|last| time_nanos <= last);
        let log_time = u64::try_from(time_nanos).ok().filter(|_| !earlier).ok_or_else(|| {
            let after =
                topic.last_nanos.map_or("the start of the log".to_owned(), |last| format!("{last} ns"));
            DataError::invalid(
                &self.path,
                format!("{} at {time_nanos} ns does not come after {after}", topic.name),
            )
        })?;
        let header = MessageHeader {
            channel_id: topic.channel_id,
            sequence: topic.sequence,
            log_time,
            publish_time: log_time,
        };
        self.writer
            .write_to_known_channel(&header, &self.buffer)
            .map_err(|fault| from_mcap(&self.path, fault))?;
        topic.sequence = topic.sequence.wrapping_add(1);
        topic.last_nanos = Some(time_nanos);
        Ok(())
    }

    fn cannot_encode(&self, topic: &Topic, fault: &dyn std::error::Error) -> DataError {
        DataError::invalid(&self.path, format!("a message on {} cannot be encoded: {fault}", topic.name))
    }
}

/// An error of the MCAP library as one of ours.
fn from_mcap(path: &Path, fault: McapError) -> DataError {
    match fault {
        McapError::Io(source) => DataError::io(path, source),
        fault => DataError::invalid(path, fault.to_string()),
    }
}
