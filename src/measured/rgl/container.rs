//! The container: a list of named arrays of any shape, and their numbers.
//!
//! `tensor_file` and a zero byte, two bytes of version, u32 number of fields; for each field u16 length of its name, the name,
//! u16 number of axes, u8 type, u64 offset of its numbers from the start of the file, u64 length of each axis. All integers are
//! little-endian. After Dupuy & Jakob, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering", 2018,
//! and the files of their database.

use crate::error::{ContainerFault, Reason};

/// The first bytes of a file.
pub(crate) const MAGIC: &[u8; 12] = b"tensor_file\0";
/// The version that is known.
const VERSION: [u8; 2] = [1, 0];
/// Arrays start at multiples of this: a gap before the end of the file may be smaller.
const ALIGNMENT: usize = 8;
/// More axes or fields than any such file has.
const MOST_AXES: usize = 16;
const MOST_FIELDS: usize = 256;

/// The types of numbers and their sizes in bytes.
const SIZES: [usize; 11] = [1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8];
const U8: u8 = 1;
const F32: u8 = 10;

/// The fields of a file, in its order.
#[derive(Debug)]
pub(crate) struct TensorFile<'a> {
    fields: Vec<Field<'a>>,
}

/// A named array.
#[derive(Clone, Debug)]
pub(crate) struct Field<'a> {
    pub(crate) name: &'a str,
    pub(crate) shape: Vec<usize>,
    kind: u8,
    offset: usize,
    bytes: &'a [u8],
}

/// Reads integers one after the other.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], ContainerFault> {
        let end = self.at + count;
        let taken = self.bytes.get(self.at..end).ok_or(ContainerFault::Truncated {
            expected: end as u64,
            got: self.bytes.len() as u64,
            dimensions: None,
        })?;
        self.at = end;
        Ok(taken)
    }

    fn integer<const N: usize>(&mut self) -> Result<u64, ContainerFault> {
        Ok(self.take(N)?.iter().rev().fold(0, |sum, &byte| sum << 8 | u64::from(byte)))
    }
}

impl<'a> TensorFile<'a> {
    /// Checks the list of fields and where their numbers lie: inside of the file, behind the list, apart from each other, and
    /// nothing behind them. Memory is taken for what the file's length covers.
    ///
    /// # Errors
    /// [`Reason::Container`], or [`Reason::Field`] with the field's name.
    pub(crate) fn parse(bytes: &'a [u8]) -> Result<Self, Reason> {
        if !bytes.starts_with(MAGIC) {
            let advice = "check that it is the right one";
            return Err(
                ContainerFault::OtherFormat { format: "a file of another kind", wanted: "an RGL", advice }.into()
            );
        }
        let mut cursor = Cursor { bytes, at: MAGIC.len() };
        let version = cursor.take(VERSION.len())?;
        if version != VERSION {
            let what = format!("RGL tensor file of version {}.{}, not 1.0", version[0], version[1]);
            return Err(Reason::Unsupported { what, advice: "convert it to version 1.0" });
        }
        let count = cursor.integer::<4>()? as usize;
        if count > MOST_FIELDS {
            return Err(header(format!("announces {count} fields, more than {MOST_FIELDS}")));
        }
        let mut fields = Vec::new();
        for _ in 0..count {
            let field = Field::read(&mut cursor)?;
            if fields.iter().any(|other: &Field| other.name == field.name) {
                return Err(field.wrong("occurs twice; fetch the file again"));
            }
            fields.push(field);
        }
        check_places(&fields, cursor.at, bytes.len())?;
        Ok(Self { fields })
    }

    /// The field of this name.
    pub(crate) fn find(&self, name: &str) -> Option<&Field<'a>> {
        self.fields.iter().find(|field| field.name == name)
    }
}

/// Arrays follow the list, do not overlap, and fill the file but for the gaps of their alignment.
fn check_places(fields: &[Field<'_>], start: usize, size: usize) -> Result<(), Reason> {
    let mut ordered: Vec<&Field> = fields.iter().collect();
    ordered.sort_by_key(|field| (field.offset, field.bytes.len()));
    let (mut end, mut before) = (start, "the list of fields");
    for field in ordered {
        if field.offset < end {
            return Err(field.wrong(&format!("offset {} lies inside of {before}; fetch the file again", field.offset)));
        }
        (end, before) = (field.offset + field.bytes.len(), field.name);
    }
    if size - end >= ALIGNMENT {
        let (expected, got) = (end as u64, size as u64);
        return Err(header(format!("trailing bytes: {}, {got} instead of {expected} bytes", got - expected)));
    }
    Ok(())
}

/// An error about the list of fields.
fn header(what: String) -> Reason {
    ContainerFault::Header { what }.into()
}

impl<'a> Field<'a> {
    fn read(cursor: &mut Cursor<'a>) -> Result<Self, Reason> {
        let length = cursor.integer::<2>()? as usize;
        let place = cursor.at;
        let Ok(name) = std::str::from_utf8(cursor.take(length)?) else {
            return Err(header(format!("the name of a field at byte {place} is not UTF-8")));
        };
        let mut field = Self { name, shape: Vec::new(), kind: 0, offset: 0, bytes: &[] };
        let axes = cursor.integer::<2>()? as usize;
        if axes > MOST_AXES {
            return Err(field.wrong(&format!("{axes} axes, more than {MOST_AXES}; fetch the file again")));
        }
        field.kind = cursor.integer::<1>()? as u8;
        let Some(&size) = usize::from(field.kind).checked_sub(1).and_then(|kind| SIZES.get(kind)) else {
            return Err(field.wrong(&format!("type {} does not exist; fetch the file again", field.kind)));
        };
        let offset = cursor.integer::<8>()?;
        let mut bytes = size as u64;
        for _ in 0..axes {
            let length = cursor.integer::<8>()?;
            field.shape.push(usize::try_from(length).unwrap_or(usize::MAX));
            bytes = bytes.saturating_mul(length);
        }
        let whole = cursor.bytes.len() as u64;
        let end = offset.saturating_add(bytes);
        if end > whole {
            return Err(field.wrong(&format!("ends at byte {end} of {whole}: truncated; fetch the file again")));
        }
        field.offset = offset as usize;
        field.bytes = &cursor.bytes[offset as usize..end as usize];
        Ok(field)
    }

    /// An error about this field.
    pub(crate) fn wrong(&self, fault: &str) -> Reason {
        Reason::Field { name: self.name.to_owned(), fault: fault.to_owned() }
    }

    /// Its bytes, if it is an array of them.
    pub(crate) fn bytes(&self) -> Result<&'a [u8], Reason> {
        self.must_be(U8, "bytes")?;
        Ok(self.bytes)
    }

    /// Its numbers, if they are single precision.
    pub(crate) fn floats(&self) -> Result<impl Iterator<Item = f32> + use<'a>, Reason> {
        self.must_be(F32, "numbers in single precision")?;
        Ok(self.bytes.as_chunks().0.iter().map(|&bytes| f32::from_le_bytes(bytes)))
    }

    fn must_be(&self, kind: u8, what: &str) -> Result<(), Reason> {
        if self.kind == kind {
            return Ok(());
        }
        Err(self.wrong(&format!("type {}, not {kind} ({what}); fetch the file again", self.kind)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Whatever follows the magic, the answer is an error or fields inside of the file.
        #[test]
        fn any_bytes_are_answered(rest in prop::collection::vec(any::<u8>(), 0..200), small in any::<bool>()) {
            let mut bytes = MAGIC.to_vec();
            bytes.extend([1, 0]);
            if small {
                bytes.extend([2, 0, 0, 0, 1, 0, b'a', 1, 0, 1]);
            }
            bytes.extend(&rest);
            if let Ok(file) = TensorFile::parse(&bytes) {
                for field in file.fields {
                    prop_assert!(field.bytes.len() <= bytes.len());
                }
            }
        }
    }

    #[test]
    fn the_smallest_file_has_no_field() {
        let bytes = [&MAGIC[..], &[1, 0, 0, 0, 0, 0]].concat();
        assert!(TensorFile::parse(&bytes).unwrap().fields.is_empty());
    }
}
