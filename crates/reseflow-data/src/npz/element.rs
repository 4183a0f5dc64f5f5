//! The elements of a `.npy` array: `float32`, `int32`, `uint8` and texts, little- or big-endian, in C or Fortran order.

use std::io::{self, Read, Write};

use super::header::{Header, dtype_name};

/// Elements decoded at a time, so that a header that lies about its size costs no memory.
const BATCH: usize = 1 << 14;

/// A number that an array may hold.
pub(crate) trait Element: Copy + Default {
    /// NumPy's name of the type.
    const DTYPE: &'static str;
    /// NumPy's type string as it is written.
    const DESCR: &'static str;
    /// Bytes per element.
    const SIZE: usize;

    /// Whether an array of this type string is big-endian; `None` where it holds another type.
    fn endianness(descr: &str) -> Option<bool>;

    /// Decodes one element from exactly `SIZE` bytes.
    fn decode(bytes: &[u8], big_endian: bool) -> Self;

    /// Appends the element's little-endian bytes.
    fn encode(self, bytes: &mut Vec<u8>);
}

/// Numbers of four bytes, in either order.
macro_rules! element_of_four_bytes {
    ($number:ty, $dtype:literal, $little:literal, $big:literal) => {
        impl Element for $number {
            const DTYPE: &'static str = $dtype;
            const DESCR: &'static str = $little;
            const SIZE: usize = 4;

            fn endianness(descr: &str) -> Option<bool> {
                match descr {
                    $little => Some(false),
                    $big => Some(true),
                    _ => None,
                }
            }

            fn decode(bytes: &[u8], big_endian: bool) -> Self {
                let mut word = [0; 4];
                word.copy_from_slice(bytes);
                if big_endian { Self::from_be_bytes(word) } else { Self::from_le_bytes(word) }
            }

            fn encode(self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }
        }
    };
}

element_of_four_bytes!(f32, "float32", "<f4", ">f4");
element_of_four_bytes!(i32, "int32", "<i4", ">i4");

impl Element for u8 {
    const DTYPE: &'static str = "uint8";
    const DESCR: &'static str = "|u1";
    const SIZE: usize = 1;

    fn endianness(descr: &str) -> Option<bool> {
        matches!(descr, "|u1" | "<u1" | ">u1").then_some(false)
    }

    fn decode(bytes: &[u8], _big_endian: bool) -> Self {
        bytes[0]
    }

    fn encode(self, bytes: &mut Vec<u8>) {
        bytes.push(self);
    }
}

/// Reads all elements into C order, and makes sure that nothing follows them.
pub(super) fn read_all<T: Element>(
    reader: &mut dyn Read,
    header: &Header,
    big_endian: bool,
) -> io::Result<Vec<T>> {
    let count = header.len().ok_or_else(|| io::Error::from(io::ErrorKind::UnexpectedEof))?;
    let mut data = Vec::with_capacity(count.min(64 * BATCH));
    let mut bytes = vec![0; T::SIZE * BATCH.min(count)];
    while data.len() < count {
        let batch = &mut bytes[..T::SIZE * BATCH.min(count - data.len())];
        reader.read_exact(batch)?;
        data.extend(batch.chunks_exact(T::SIZE).map(|element| T::decode(element, big_endian)));
    }
    // Reading to the very end is also what makes the archive compare its checksum.
    if reader.read(&mut [0])? != 0 {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "more bytes than its shape accounts for"));
    }
    Ok(if header.fortran_order { from_fortran_order(&data, &header.shape) } else { data })
}

/// Writes all elements, little-endian.
pub(super) fn write_all<T: Element>(sink: &mut dyn Write, data: &[T]) -> io::Result<()> {
    for_each_batch(data, |bytes| sink.write_all(bytes))
}

/// Hands out the elements' little-endian bytes, some thousand elements at a time.
pub(super) fn for_each_batch<T: Element, E>(
    data: &[T],
    mut consume: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<(), E> {
    let mut bytes = Vec::with_capacity(T::SIZE * BATCH.min(data.len()));
    for batch in data.chunks(BATCH) {
        bytes.clear();
        batch.iter().for_each(|element| element.encode(&mut bytes));
        consume(&bytes)?;
    }
    Ok(())
}

/// Reads an array that holds one text. The inner error names the element type of one that does not.
pub(super) fn read_text(reader: &mut dyn Read, header: &Header) -> io::Result<Result<String, String>> {
    let bytes_per_char = match header.descr.trim_start_matches(['<', '>', '|']).chars().next() {
        Some('U') if header.len() == Some(1) => 4,
        Some('S') if header.len() == Some(1) => 1,
        Some('u') if u8::endianness(&header.descr).is_some() && header.shape.len() == 1 => 1,
        _ => return Ok(Err(dtype_name(&header.descr))),
    };
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes)?;
    let text = if bytes_per_char == 1 {
        String::from_utf8(bytes).ok()
    } else {
        let big_endian = header.descr.starts_with('>');
        bytes.chunks_exact(4).map(|code| char::from_u32(code_point(code, big_endian))).collect()
    };
    // NumPy pads strings with zeros, and drops them on reading.
    let text = text.map(|text| text.trim_end_matches('\0').to_owned());
    text.map(Ok).ok_or_else(|| io::Error::new(io::ErrorKind::InvalidData, "not a valid text"))
}

fn code_point(bytes: &[u8], big_endian: bool) -> u32 {
    let fold = |code: u32, &byte: &u8| code << 8 | u32::from(byte);
    if big_endian { bytes.iter().fold(0, fold) } else { bytes.iter().rev().fold(0, fold) }
}

/// Reorders elements whose first index runs fastest so that the last one does.
fn from_fortran_order<T: Copy>(data: &[T], shape: &[usize]) -> Vec<T> {
    let strides: Vec<usize> = shape
        .iter()
        .scan(1, |stride, &extent| {
            let this = *stride;
            *stride *= extent;
            Some(this)
        })
        .collect();
    let mut index = vec![0; shape.len()];
    let mut reordered = Vec::with_capacity(data.len());
    for _ in 0..data.len() {
        reordered.push(data[index.iter().zip(&strides).map(|(i, stride)| i * stride).sum::<usize>()]);
        for axis in (0..shape.len()).rev() {
            index[axis] += 1;
            if index[axis] < shape[axis] {
                break;
            }
            index[axis] = 0;
        }
    }
    reordered
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fortran_order_is_undone() {
        // a[i, j, k] = 100 i + 10 j + k, as numpy.asfortranarray(a).ravel(order="K") lays it out.
        let shape = [2, 3, 2];
        let stored = [0, 100, 10, 110, 20, 120, 1, 101, 11, 111, 21, 121];
        let expected: Vec<i32> = (0..2)
            .flat_map(|i| (0..3).flat_map(move |j| (0..2).map(move |k| 100 * i + 10 * j + k)))
            .collect();
        assert_eq!(from_fortran_order(&stored, &shape), expected);
    }

    #[test]
    fn both_byte_orders_are_understood() {
        let header = Header { descr: String::new(), fortran_order: false, shape: vec![2] };
        let little: Vec<u8> = [1.5_f32, -2.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        let big: Vec<u8> = [1.5_f32, -2.0].iter().flat_map(|x| x.to_be_bytes()).collect();
        assert_eq!(read_all::<f32>(&mut &little[..], &header, false).unwrap(), [1.5, -2.0]);
        assert_eq!(read_all::<f32>(&mut &big[..], &header, true).unwrap(), [1.5, -2.0]);
        assert!(read_all::<f32>(&mut &little[..7], &header, false).is_err());
        let longer = [little, vec![0]].concat();
        assert!(read_all::<f32>(&mut &longer[..], &header, false).is_err());
    }

    #[test]
    fn a_header_that_promises_terabytes_costs_nothing() {
        let header = Header { descr: "<f4".into(), fortran_order: false, shape: vec![1 << 40] };
        assert_eq!(
            read_all::<f32>(&mut io::empty(), &header, false).unwrap_err().kind(),
            io::ErrorKind::UnexpectedEof
        );
    }

    #[test]
    fn texts_come_in_three_kinds() {
        let header = |descr: &str, shape: &[usize]| Header {
            descr: descr.into(),
            fortran_order: false,
            shape: shape.to_vec(),
        };
        let utf32: Vec<u8> = "é→".chars().chain(['\0']).flat_map(|c| u32::from(c).to_be_bytes()).collect();
        assert_eq!(read_text(&mut &utf32[..], &header(">U3", &[])).unwrap().unwrap(), "é→");
        assert_eq!(read_text(&mut "é→\0".as_bytes(), &header("|S6", &[])).unwrap().unwrap(), "é→");
        assert_eq!(read_text(&mut "é→".as_bytes(), &header("|u1", &[5])).unwrap().unwrap(), "é→");
        assert_eq!(
            read_text(&mut "".as_bytes(), &header("|O", &[])).unwrap().unwrap_err(),
            "object (pickled)"
        );
        assert_eq!(read_text(&mut "ab".as_bytes(), &header("|S1", &[2])).unwrap().unwrap_err(), "|S1");
        assert!(read_text(&mut &[255, 254][..], &header("|u1", &[2])).is_err());
    }
}
