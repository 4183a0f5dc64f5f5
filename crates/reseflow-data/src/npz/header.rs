//! The header of a `.npy` array: a Python dictionary literal with `descr`, `fortran_order` and `shape`.
//!
//! Source: NumPy's `numpy.lib.format`, versions 1.0 to 3.0. The grammar is NumPy's own output, not all of Python.

use std::io::{self, Read};

/// The first bytes of every `.npy` array.
pub(super) const MAGIC: &[u8; 6] = b"\x93NUMPY";

/// NumPy itself refuses longer headers unless told that the file is trusted.
const LONGEST_HEADER: usize = 10_000;

/// What an array's header says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    /// NumPy's type string, such as `<f4`; the whole list for structured arrays.
    pub(super) descr: String,
    /// Whether the first index runs fastest.
    pub(super) fortran_order: bool,
    /// The array's shape.
    pub(super) shape: Vec<usize>,
}

impl Header {
    /// Reads a header and leaves `reader` at the first element.
    pub(super) fn read(reader: &mut dyn Read) -> io::Result<Self> {
        let mut start = [0; 8];
        reader.read_exact(&mut start)?;
        if start[..6] != *MAGIC {
            return Err(broken("it does not start like a .npy array"));
        }
        let length = if start[6] == 1 {
            let mut length = [0; 2];
            reader.read_exact(&mut length)?;
            usize::from(u16::from_le_bytes(length))
        } else {
            let mut length = [0; 4];
            reader.read_exact(&mut length)?;
            u32::from_le_bytes(length) as usize
        };
        if length > LONGEST_HEADER {
            return Err(broken(format!(
                "its header claims {length} bytes, at most {LONGEST_HEADER} are expected"
            )));
        }
        let mut text = vec![0; length];
        reader.read_exact(&mut text)?;
        let text = String::from_utf8_lossy(&text);
        Parser { rest: text.trim() }
            .header()
            .ok_or_else(|| broken(format!("its header is not NumPy's: {}", text.trim())))
    }

    /// The number of elements, where it fits.
    pub(super) fn len(&self) -> Option<usize> {
        self.shape.iter().try_fold(1_usize, |product, &extent| product.checked_mul(extent))
    }
}

/// The bytes that NumPy writes before the elements of a C-ordered array: version 1.0, padded to a multiple of 64.
pub(super) fn encode(descr: &str, shape: &[usize]) -> Vec<u8> {
    let extents = match shape {
        [only] => format!("({only},)"),
        _ => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    };
    let mut text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {extents}, }}");
    let padding = 64 - (MAGIC.len() + 4 + text.len() + 1) % 64;
    text.extend(std::iter::repeat_n(' ', padding % 64));
    text.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.into_bytes());
    bytes
}

/// The name that `numpy.dtype` prints for a type string.
pub(super) fn dtype_name(descr: &str) -> String {
    if descr.contains('O') {
        return "object (pickled)".to_owned();
    }
    let plain = descr.trim_start_matches(['<', '>', '|', '=']);
    let (kind, size) = plain.split_at_checked(1).unwrap_or((plain, ""));
    let bits = size.parse::<u32>().ok().and_then(|bytes| bytes.checked_mul(8));
    match (kind, bits) {
        ("b", _) => "bool".to_owned(),
        ("f", Some(bits)) => format!("float{bits}"),
        ("i", Some(bits)) => format!("int{bits}"),
        ("u", Some(bits)) => format!("uint{bits}"),
        ("c", Some(bits)) => format!("complex{bits}"),
        _ => descr.to_owned(),
    }
}

fn broken(fault: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, fault.into())
}

/// A cursor over the dictionary literal. Every method takes what it names or gives `None`.
struct Parser<'a> {
    rest: &'a str,
}

impl<'a> Parser<'a> {
    fn header(mut self) -> Option<Header> {
        let (mut descr, mut fortran_order, mut shape) = (None, None, None);
        self.token("{")?;
        while self.token("}").is_none() {
            let key = self.string()?;
            self.token(":")?;
            match key {
                "descr" => descr = Some(self.string().or_else(|| self.list())?.to_owned()),
                "fortran_order" => fortran_order = Some(self.boolean()?),
                "shape" => shape = Some(self.extents()?),
                _ => return None,
            }
            if self.token(",").is_none() {
                self.token("}")?;
                break;
            }
        }
        Some(Header { descr: descr?, fortran_order: fortran_order?, shape: shape? })
    }

    fn token(&mut self, token: &str) -> Option<()> {
        self.rest = self.rest.trim_start().strip_prefix(token)?;
        Some(())
    }

    fn string(&mut self) -> Option<&'a str> {
        let quote = self.rest.trim_start().chars().next().filter(|c| matches!(c, '\'' | '"'))?;
        let (string, rest) = self.rest.trim_start()[1..].split_once(quote)?;
        self.rest = rest;
        Some(string)
    }

    /// A structured type, of which only the extent matters, because no such array is accepted.
    fn list(&mut self) -> Option<&'a str> {
        let text = self.rest.trim_start();
        let mut depth = 0_usize;
        for (at, c) in text.char_indices() {
            match c {
                '[' => depth += 1,
                ']' => depth = depth.checked_sub(1)?,
                _ => {}
            }
            if depth == 0 {
                let (list, rest) = text.split_at_checked(at + 1)?;
                self.rest = rest;
                return Some(list).filter(|list| list.starts_with('['));
            }
        }
        None
    }

    fn boolean(&mut self) -> Option<bool> {
        self.token("True").map(|()| true).or_else(|| self.token("False").map(|()| false))
    }

    fn extents(&mut self) -> Option<Vec<usize>> {
        self.token("(")?;
        let (inside, rest) = self.rest.split_once(')')?;
        self.rest = rest;
        // Python 2 wrote long integers with a trailing L.
        let extents = inside.split(',').map(|extent| extent.trim().trim_end_matches('L'));
        extents.filter(|extent| !extent.is_empty()).map(|extent| extent.parse().ok()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Option<Header> {
        Parser { rest: text }.header()
    }

    #[test]
    fn numpys_spellings_are_understood() {
        let header = parse("{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }").unwrap();
        assert_eq!(header, Header { descr: "<f4".into(), fortran_order: false, shape: vec![3, 4] });
        let header = parse("{\"shape\": (7L,), \"fortran_order\": True, \"descr\": \"|u1\"}").unwrap();
        assert_eq!(header, Header { descr: "|u1".into(), fortran_order: true, shape: vec![7] });
        let header = parse("{'descr': '<U12', 'fortran_order': False, 'shape': (), }").unwrap();
        assert_eq!((header.shape.len(), header.len()), (0, Some(1)));
        let header =
            parse("{'descr': [('a', '<f4', (2,)), ('b', '|u1')], 'fortran_order': False, 'shape': (1,)}")
                .unwrap();
        assert_eq!(header.descr, "[('a', '<f4', (2,)), ('b', '|u1')]");
    }

    #[test]
    fn anything_else_is_refused_without_a_panic() {
        for text in [
            "",
            "{",
            "}",
            "[]",
            "{'descr': '<f4'}",
            "{'descr': '<f4', 'fortran_order': 0, 'shape': (1,)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (-1,)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999999,)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': 3}",
            "{'descr': [, 'fortran_order': False, 'shape': (1,)}",
            "{'descr': é, 'fortran_order': False}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (1,), 'more': 1}",
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
        let mut claims_too_much = MAGIC.to_vec();
        claims_too_much.extend([2, 0, 255, 255, 255, 255]);
        assert!(
            Header::read(&mut &claims_too_much[..]).unwrap_err().to_string().contains("4294967295 bytes")
        );
        assert!(
            Header { descr: String::new(), fortran_order: false, shape: vec![usize::MAX, 2] }.len().is_none()
        );
    }

    #[test]
    fn headers_are_aligned_and_read_back() {
        for shape in [vec![], vec![5], vec![1, 2, 3], vec![123_456_789; 9]] {
            let bytes = encode("<f4", &shape);
            assert_eq!(bytes.len() % 64, 0);
            let header = Header::read(&mut &bytes[..]).unwrap();
            assert_eq!(header, Header { descr: "<f4".into(), fortran_order: false, shape });
        }
    }

    #[test]
    fn types_are_named_as_numpy_names_them() {
        let names =
            [("<f8", "float64"), (">f4", "float32"), ("|u1", "uint8"), ("|b1", "bool"), ("<i8", "int64")];
        for (descr, name) in names {
            assert_eq!(dtype_name(descr), name);
        }
        assert_eq!(dtype_name("|O"), "object (pickled)");
        assert_eq!(dtype_name("<U5"), "<U5");
        assert_eq!(dtype_name(""), "");
        assert_eq!(dtype_name("\u{fffd}f4"), "\u{fffd}f4", "a damaged header may hold anything");
    }
}
