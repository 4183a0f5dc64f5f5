//! Reading and writing NumPy's `.npz`: a zip archive with one `.npy` member per array.
//!
//! Source: NumPy's `numpy.lib.format` and `numpy.savez`. What is written opens with `numpy.load`, without pickle, and depends on
//! nothing but the arrays: members are stored uncompressed, in the order given, with zip's zero time stamp.

mod element;
mod header;

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, Write};
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::DataError;
pub(crate) use element::Element;
use header::Header;

/// An array in C order: the last index runs fastest.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Array<T> {
    pub(crate) shape: Vec<usize>,
    pub(crate) data: Vec<T>,
}

impl<T: Element> Array<T> {
    /// Hands out the little-endian bytes of the elements, some thousand elements at a time.
    pub(crate) fn for_each_batch(&self, mut consume: impl FnMut(&[u8])) {
        let Ok(()) = element::for_each_batch(&self.data, |bytes| {
            consume(bytes);
            Ok::<(), std::convert::Infallible>(())
        });
    }
}

/// An open `.npz` file.
pub(crate) struct NpzReader {
    path: PathBuf,
    archive: ZipArchive<BufReader<File>>,
}

impl NpzReader {
    /// Opens the archive and reads its directory.
    ///
    /// # Errors
    /// When the file is missing, not a zip archive or cut off.
    pub(crate) fn open(path: &Path) -> Result<Self, DataError> {
        let io_error = |source| DataError::io(path, source);
        let mut file = File::open(path).map_err(io_error)?;
        if file.metadata().map_err(io_error)?.is_dir() {
            return Err(DataError::invalid(path, "is a folder, expected an .npz file"));
        }
        let mut magic = Vec::new();
        (&mut file).take(6).read_to_end(&mut magic).map_err(io_error)?;
        file.rewind().map_err(io_error)?;
        if magic == header::MAGIC {
            return Err(DataError::invalid(
                path,
                "is a single .npy array, expected an .npz archive of named arrays",
            ));
        }
        if !magic.starts_with(b"PK") {
            return Err(DataError::invalid(
                path,
                "is not an .npz file (it does not start like a zip archive)",
            ));
        }
        match ZipArchive::new(BufReader::with_capacity(1 << 16, file)) {
            Ok(archive) => Ok(Self { path: path.to_owned(), archive }),
            Err(ZipError::Io(source)) if source.kind() != io::ErrorKind::UnexpectedEof => {
                Err(io_error(source))
            }
            Err(fault) => {
                Err(DataError::invalid(path, format!("is a broken .npz file, perhaps cut off ({fault})")))
            }
        }
    }

    /// Whether the archive holds an array of this name.
    pub(crate) fn contains(&self, name: &str) -> bool {
        self.archive.index_for_name(&member(name)).is_some()
    }

    /// The names of the arrays, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let names = self.archive.file_names_raw().map(|name| String::from_utf8_lossy(name));
        let mut names: Vec<String> =
            names.filter_map(|name| name.strip_suffix(".npy").map(str::to_owned)).collect();
        names.sort();
        names
    }

    /// Reads one array.
    ///
    /// # Errors
    /// When it is missing, of another element type, or damaged.
    pub(crate) fn array<T: Element>(&mut self, name: &str) -> Result<Array<T>, DataError> {
        if !self.contains(name) {
            let held = self.names().join(", ");
            let fault =
                format!("has no array `{name}`; it holds {}", if held.is_empty() { "none" } else { &held });
            return Err(DataError::invalid(&self.path, fault));
        }
        self.read_member(name, |header, reader| {
            let Some(big_endian) = T::endianness(&header.descr) else {
                let got = header::dtype_name(&header.descr);
                return Ok(Err(format!("`{name}` has dtype {got}, expected {}", T::DTYPE)));
            };
            let data = element::read_all(reader, &header, big_endian)?;
            Ok(Ok(Array { shape: header.shape, data }))
        })
    }

    /// Reads an array that holds one text: a unicode or byte string, or UTF-8 in a row of `uint8`.
    ///
    /// # Errors
    /// When it is missing, holds something else, or is damaged.
    pub(crate) fn text(&mut self, name: &str) -> Result<String, DataError> {
        self.read_member(name, |header, reader| {
            Ok(element::read_text(reader, &header)?.map_err(|got| {
                format!(
                    "`{name}` has dtype {got}, expected one text (for example numpy.array(json.dumps(…)))"
                )
            }))
        })
    }

    /// Opens member `name`, parses its header and hands both to `read`, whose inner error is a fault in plain words.
    fn read_member<V>(
        &mut self,
        name: &str,
        read: impl FnOnce(Header, &mut dyn Read) -> io::Result<Result<V, String>>,
    ) -> Result<V, DataError> {
        let path = &self.path;
        let mut entry = self
            .archive
            .by_name(&member(name))
            .map_err(|fault| DataError::invalid(path, format!("`{name}` cannot be unpacked ({fault})")))?;
        let result = Header::read(&mut entry).and_then(|header| read(header, &mut entry));
        match result {
            Ok(Ok(value)) => Ok(value),
            Ok(Err(fault)) => Err(DataError::invalid(path, fault)),
            Err(fault) if fault.kind() == io::ErrorKind::UnexpectedEof => Err(DataError::invalid(
                path,
                format!("`{name}` ends before its last element: the file was cut off"),
            )),
            Err(fault) => Err(DataError::invalid(path, format!("`{name}` is damaged ({fault})"))),
        }
    }
}

/// An `.npz` archive under way; one that is given up is left as it is.
pub(crate) struct NpzWriter<W: Write + Seek> {
    // Dropped, it would complete the archive, and complain on standard error where it cannot.
    archive: ManuallyDrop<ZipWriter<W>>,
}

impl<W: Write + Seek> NpzWriter<W> {
    pub(crate) fn new(sink: W) -> Self {
        Self { archive: ManuallyDrop::new(ZipWriter::new(sink)) }
    }

    /// Adds an array.
    pub(crate) fn array<T: Element>(&mut self, name: &str, array: &Array<T>) -> io::Result<()> {
        let bytes = (array.data.len() as u64).saturating_mul(T::SIZE as u64);
        self.start(name, T::DESCR, &array.shape, bytes)?;
        element::write_all(&mut *self.archive, &array.data)
    }

    /// Adds a text as a 0-d unicode array, which `str(numpy.load(file)[name])` gives back.
    pub(crate) fn text(&mut self, name: &str, text: &str) -> io::Result<()> {
        // NumPy cannot hold a unicode array of width 0; it writes the empty string with width 1.
        let width = text.chars().count().max(1);
        self.start(name, &format!("<U{width}"), &[], 4 * width as u64)?;
        let mut codes: Vec<u8> = text.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
        codes.resize(4 * width, 0);
        self.archive.write_all(&codes)
    }

    /// Writes the archive's directory and hands the sink back.
    pub(crate) fn finish(self) -> io::Result<W> {
        Ok(ManuallyDrop::into_inner(self.archive).finish()?)
    }

    fn start(&mut self, name: &str, descr: &str, shape: &[usize], bytes: u64) -> io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(zip::DateTime::default())
            .large_file(bytes > u64::from(u32::MAX) - (1 << 20));
        self.archive.start_file(member(name), options)?;
        self.archive.write_all(&header::encode(descr, shape))
    }
}

fn member(array: &str) -> String {
    format!("{array}.npy")
}
