//! KTX2 files: one 2-D texture with 7 mip levels in half precision, rounded up, as a GPU takes it.
//!
//! `VK_FORMAT_R16_SFLOAT` or `VK_FORMAT_R16G16B16A16_SFLOAT` (A is the maximum), 1024 x 1024, no supercompression, linear,
//! primaries unspecified. Source of every rule: KTX File Format Specification 2.0, Khronos Data Format Specification 1.3.

use std::io::{Read, Write};

use ::ktx2::dfd::{Basic, Block};
use ::ktx2::{Format, Header, Index, KeyValueDataIterator, LevelIndex, MAGIC};
use half::f16;

use crate::atlas::error::AtlasError;
use crate::atlas::f16_round_up::f16_rounded_up;
use crate::atlas::sidecar::{Provenance, stored_range};
use crate::atlas::texture::{Atlas, AtlasChannels, LEVELS, SIZE, level_size};
use crate::files::attributes::{attributes, from_attributes};
use crate::files::{atlas_of_levels, read_all};

/// Bytes of one stored value, which are also the `typeSize` of both formats.
const VALUE: usize = 2;
/// Offset of the primaries in the data format descriptor: 4 bytes of total size, 8 of block header, the colour model.
const PRIMARIES: usize = 13;

fn format(channels: AtlasChannels) -> Format {
    match channels {
        AtlasChannels::Max => Format::R16_SFLOAT,
        AtlasChannels::Rgba => Format::R16G16B16A16_SFLOAT,
    }
}

/// The data format descriptor with its leading total size.
fn descriptor(channels: AtlasChannels) -> Vec<u8> {
    let (mut basic, _) = Basic::from_format(format(channels)).expect("both formats are in the generator's table");
    basic.color_primaries = None;
    let block = Block::Basic(basic).to_vec();
    let mut bytes = (block.len() as u32 + 4).to_le_bytes().to_vec();
    bytes.extend(block);
    bytes
}

/// Key/value data: sorted by key, each entry padded to 4 bytes, values as NUL-terminated UTF-8.
fn key_values(atlas: &Atlas, provenance: &Provenance) -> Vec<u8> {
    let (low, high) = stored_range(atlas);
    let mut list = attributes(atlas, provenance, "half precision, rounded towards plus infinity");
    list.push(("KTXorientation", "rd".to_owned()));
    list.push(("KTXwriter", provenance.program.clone()));
    list.push(("brdfit.range", format!("{low} {high}")));
    list.sort_unstable();
    let mut bytes = Vec::new();
    for (key, value) in list {
        bytes.extend((key.len() as u32 + value.len() as u32 + 2).to_le_bytes());
        for text in [key, &value] {
            bytes.extend(text.as_bytes());
            bytes.push(0);
        }
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

/// The file as bytes.
#[must_use]
pub fn to_bytes(atlas: &Atlas, provenance: &Provenance) -> Vec<u8> {
    let texel = VALUE * atlas.channels().count();
    let (descriptor, key_values) = (descriptor(atlas.channels()), key_values(atlas, provenance));
    let dfd = Header::LENGTH + LEVELS * LevelIndex::LENGTH;
    let kvd = dfd + descriptor.len();

    // the smallest level comes first, each begins at a multiple of the texel's size and of 4
    let mut end = kvd + key_values.len();
    let mut index = [LevelIndex { byte_offset: 0, byte_length: 0, uncompressed_byte_length: 0 }; LEVELS];
    for (k, entry) in index.iter_mut().enumerate().rev() {
        let (start, length) = (end.next_multiple_of(texel.max(4)), texel * level_size(k) * level_size(k));
        end = start + length;
        *entry = LevelIndex {
            byte_offset: start as u64,
            byte_length: length as u64,
            uncompressed_byte_length: length as u64,
        };
    }
    let header = Header {
        format: Some(format(atlas.channels())),
        type_size: VALUE as u32,
        pixel_width: SIZE as u32,
        pixel_height: SIZE as u32,
        pixel_depth: 0,
        layer_count: 0,
        face_count: 1,
        level_count: LEVELS as u32,
        supercompression_scheme: None,
        index: Index {
            dfd_byte_offset: dfd as u32,
            dfd_byte_length: descriptor.len() as u32,
            kvd_byte_offset: kvd as u32,
            kvd_byte_length: key_values.len() as u32,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };

    let mut bytes = Vec::with_capacity(end);
    bytes.extend(header.as_bytes());
    bytes.extend(index.iter().flat_map(LevelIndex::as_bytes));
    bytes.extend(descriptor);
    bytes.extend(key_values);
    for (entry, level) in index.iter().zip(atlas.levels()).rev() {
        bytes.resize(entry.byte_offset as usize, 0);
        bytes.extend(level.texels().iter().flat_map(|&value| f16_rounded_up(value).to_le_bytes()));
    }
    bytes
}

/// Writes the file; see [`to_bytes`].
///
/// # Errors
/// [`AtlasError::Io`] if `output` refuses.
pub fn write(atlas: &Atlas, provenance: &Provenance, mut output: impl Write) -> Result<(), AtlasError> {
    Ok(output.write_all(&to_bytes(atlas, provenance))?)
}

/// Reads a whole file from `input`; see [`from_bytes`].
///
/// # Errors
/// [`AtlasError::Io`] if `input` fails, and the errors of [`from_bytes`].
pub fn read(input: impl Read) -> Result<(Atlas, Provenance), AtlasError> {
    from_bytes(&read_all(input)?)
}

/// Reads a file that [`to_bytes`] wrote, or another program in the same structure.
///
/// # Errors
/// [`AtlasError::WrongFormat`] if this is no KTX2 file, [`AtlasError::Unsupported`] if it is another texture than an atlas,
/// [`AtlasError::Damaged`] if it is incomplete, holds values that no atlas has, or levels that are not the maximum of the
/// level before.
pub fn from_bytes(bytes: &[u8]) -> Result<(Atlas, Provenance), AtlasError> {
    if !bytes.starts_with(&MAGIC) {
        let why = format!("{} bytes without the signature 'KTX 20'", bytes.len());
        return Err(AtlasError::WrongFormat { expected: "a KTX2", why });
    }
    let start = bytes.first_chunk().ok_or_else(|| truncated("the header", Header::LENGTH as u64, bytes))?;
    let header = Header::from_bytes(start).map_err(|error| AtlasError::damaged(error.to_string()))?;
    let channels = check_header(&header)?;

    let descriptor_found = section(
        bytes,
        "the data format descriptor",
        u64::from(header.index.dfd_byte_offset),
        u64::from(header.index.dfd_byte_length),
    )?;
    let mut expected = descriptor(channels);
    if let (Some(&found), true) = (descriptor_found.get(PRIMARIES), descriptor_found.len() == expected.len()) {
        expected[PRIMARIES] = found;
    }
    if descriptor_found != expected {
        return Err(AtlasError::damaged("the data format descriptor contradicts the texel format"));
    }

    let key_values = section(
        bytes,
        "the key/value data",
        u64::from(header.index.kvd_byte_offset),
        u64::from(header.index.kvd_byte_length),
    )?;
    let find = |key: &str| {
        let (_, value) = KeyValueDataIterator::new(key_values).find(|(name, _)| *name == key)?;
        String::from_utf8(value.strip_suffix(&[0]).unwrap_or(value).to_vec()).ok()
    };
    if let Some(orientation) = find("KTXorientation").filter(|orientation| orientation != "rd") {
        return Err(AtlasError::unsupported(format!("KTXorientation is '{orientation}' instead of 'rd'")));
    }
    let (layout, provenance) = from_attributes(find)?;

    let level_index = section(bytes, "the level index", Header::LENGTH as u64, (LEVELS * LevelIndex::LENGTH) as u64)?;
    let mut levels = Vec::with_capacity(LEVELS);
    for (k, entry) in level_index.as_chunks().0.iter().map(LevelIndex::from_bytes).enumerate() {
        let length = (VALUE * channels.count() * level_size(k) * level_size(k)) as u64;
        if (entry.byte_length, entry.uncompressed_byte_length) != (length, length) {
            return Err(AtlasError::damaged(format!("level {k} has {} bytes instead of {length}", entry.byte_length)));
        }
        let data = section(bytes, &format!("level {k}"), entry.byte_offset, length)?;
        levels.push(data.as_chunks().0.iter().map(|&pair| f16::from_le_bytes(pair).to_f32()).collect());
    }
    Ok((atlas_of_levels(layout, channels, levels)?, provenance))
}

fn check_header(header: &Header) -> Result<AtlasChannels, AtlasError> {
    let channels = match header.format {
        Some(Format::R16_SFLOAT) => AtlasChannels::Max,
        Some(Format::R16G16B16A16_SFLOAT) => AtlasChannels::Rgba,
        other => {
            let number = other.map_or(0, |format| format.value());
            return Err(AtlasError::unsupported(format!(
                "vkFormat {number} instead of 76 (R16_SFLOAT) or 97 (R16G16B16A16_SFLOAT)"
            )));
        }
    };
    let fields = [
        ("typeSize", header.type_size, VALUE as u32),
        ("pixelWidth", header.pixel_width, SIZE as u32),
        ("pixelHeight", header.pixel_height, SIZE as u32),
        ("pixelDepth", header.pixel_depth, 0),
        ("layerCount", header.layer_count, 0),
        ("faceCount", header.face_count, 1),
        ("levelCount", header.level_count, LEVELS as u32),
        ("supercompressionScheme", header.supercompression_scheme.map_or(0, |scheme| scheme.value()), 0),
    ];
    match fields.into_iter().find(|(_, found, expected)| found != expected) {
        Some((name, found, expected)) => {
            Err(AtlasError::unsupported(format!("{name} is {found} instead of {expected}")))
        }
        None => Ok(channels),
    }
}

/// The bytes of a section, if the file has them.
fn section<'a>(bytes: &'a [u8], name: &str, offset: u64, length: u64) -> Result<&'a [u8], AtlasError> {
    let end = offset.saturating_add(length);
    let range = usize::try_from(offset).ok().zip(usize::try_from(end).ok());
    range.and_then(|(start, end)| bytes.get(start..end)).ok_or_else(|| truncated(name, end, bytes))
}

fn truncated(name: &str, end: u64, bytes: &[u8]) -> AtlasError {
    AtlasError::damaged(format!("truncated: {name} ends at byte {end}, the file at byte {}", bytes.len()))
}
