//! What an MCAP file holds, in figures: topics, counts, times and their spacing. Reads anyone's files, not only ours.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use mcap::McapError;
use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use serde::{Deserialize, Serialize};

use crate::DataError;

/// The figures of one MCAP file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct McapSummary {
    /// Messages on all topics.
    pub messages: u64,
    /// The earliest log time, nanoseconds; 0 without messages.
    pub start_nanos: u64,
    /// The latest log time, nanoseconds; 0 without messages.
    pub end_nanos: u64,
    /// The topics, by name.
    pub topics: Vec<TopicSummary>,
}

/// The figures of one topic.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TopicSummary {
    /// The topic's name.
    pub topic: String,
    /// The schema's name, such as `foxglove.PointCloud`; empty where there is none.
    pub schema: String,
    /// How messages are encoded, such as `protobuf`.
    pub encoding: String,
    /// Messages on this topic.
    pub messages: u64,
    /// The first message's log time, nanoseconds.
    pub first_nanos: u64,
    /// The last message's log time, nanoseconds.
    pub last_nanos: u64,
    /// Whether every message comes later than the one before.
    pub strictly_increasing: bool,
    /// Shortest, median and longest time between neighbouring messages, nanoseconds; `None` below two messages.
    pub spacing_nanos: Option<[i64; 3]>,
}

#[derive(Default)]
struct Times {
    schema: String,
    encoding: String,
    nanos: Vec<u64>,
}

impl McapSummary {
    /// Reads a whole MCAP file and sums it up.
    ///
    /// # Errors
    /// When the file cannot be read, is not MCAP, is cut off or damaged, or is compressed (logs of ours are not).
    pub fn read(path: impl AsRef<Path>) -> Result<Self, DataError> {
        let path = path.as_ref();
        let io_error = |source| DataError::io(path, source);
        let mut file = File::open(path).map_err(io_error)?;
        let length = file.metadata().map_err(io_error)?.len();
        let mut magic = Vec::new();
        (&mut file).take(mcap::MAGIC.len() as u64).read_to_end(&mut magic).map_err(io_error)?;
        if magic != mcap::MAGIC {
            return Err(DataError::invalid(path, "is not an MCAP file (it does not start like one)"));
        }
        file.rewind().map_err(io_error)?;
        let broken = |fault: McapError| match fault {
            McapError::Io(source) => io_error(source),
            fault => DataError::invalid(path, format!("is a broken MCAP file, perhaps cut off ({fault})")),
        };
        // Checksums come first, because the library does arithmetic on the lengths that a chunk states.
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(usize::try_from(length).unwrap_or(usize::MAX));
        let mut topics: BTreeMap<String, Times> = BTreeMap::new();
        for message in MessageReader::new_with_options(BufReader::new(file), options) {
            let message = message.map_err(broken)?;
            let channel = &message.channel;
            let times = topics.entry(channel.topic.clone()).or_insert_with(|| Times {
                schema: channel.schema.as_ref().map_or_else(String::new, |schema| schema.name.clone()),
                encoding: channel.message_encoding.clone(),
                nanos: Vec::new(),
            });
            times.nanos.push(message.log_time);
        }
        let all = || topics.values().flat_map(|times| times.nanos.iter().copied());
        Ok(Self {
            messages: all().count() as u64,
            start_nanos: all().min().unwrap_or(0),
            end_nanos: all().max().unwrap_or(0),
            topics: topics.into_iter().map(|(topic, times)| TopicSummary::of(topic, times)).collect(),
        })
    }
}

impl TopicSummary {
    fn of(topic: String, times: Times) -> Self {
        let Times { schema, encoding, nanos } = times;
        // Log times may run backwards in a file of someone else's, and two of them may differ by more than an i64 holds.
        let mut spacing: Vec<i64> = nanos
            .windows(2)
            .map(|pair| i64::try_from(i128::from(pair[1]) - i128::from(pair[0])).unwrap_or(i64::MAX))
            .collect();
        spacing.sort_unstable();
        let spacing_nanos = match spacing[..] {
            [] => None,
            [shortest, .., longest] => Some([shortest, spacing[spacing.len() / 2], longest]),
            [only] => Some([only; 3]),
        };
        Self {
            topic,
            schema,
            encoding,
            messages: nanos.len() as u64,
            first_nanos: nanos.first().copied().unwrap_or(0),
            last_nanos: nanos.last().copied().unwrap_or(0),
            strictly_increasing: spacing_nanos.is_none_or(|[shortest, ..]| shortest > 0),
            spacing_nanos,
        }
    }
}
