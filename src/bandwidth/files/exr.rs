//! OpenEXR files: one part per level, "level0" (1024 x 1024) to "level6" (16 x 16), scan lines, ZIP.
//!
//! Channels are `max`, or `R`, `G`, `B` and `max`: not `A`, which viewers take for opacity. A file lists channels by name
//! (B, G, R, max); OpenImageIO hands them out as R, G, B, max. Every part has the display window of level 0, as the format
//! asks for, its own data window from (0, 0), and all attributes.

use std::io::{Read, Write};

use ::exr::block::UncompressedBlock;
use ::exr::block::chunk::Chunk;
use ::exr::block::reader::ChunksReader;
use ::exr::error::Error as ExrError;
use ::exr::meta::attribute::{self, AttributeValue, ChannelDescription, IntegerBounds, LineOrder, SampleType, Text};
use ::exr::meta::header::{Header, LayerAttributes};
use ::exr::meta::{BlockDescription, Headers, MetaData, magic_number, sequence_end};
use ::exr::prelude::{Compression, Vec2};
use half::f16;
use rayon::prelude::*;

use crate::atlas::error::AtlasError;
use crate::atlas::f16_round_up::f16_rounded_up;
use crate::atlas::sidecar::{Provenance, stored_range};
use crate::atlas::texture::{Atlas, AtlasChannels, LEVELS, SIZE, level_size};
use crate::files::attributes::{attributes, from_attributes};
use crate::files::{atlas_of_levels, read_all};

/// Precision of the stored values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// Half precision, rounded up ([`Atlas::rounded_up`]).
    Half,
    /// Single precision, exact.
    Float,
}

impl Samples {
    fn sample_type(self) -> SampleType {
        match self {
            Self::Half => SampleType::F16,
            Self::Float => SampleType::F32,
        }
    }

    fn encoding(self) -> &'static str {
        match self {
            Self::Half => "half precision, rounded towards plus infinity",
            Self::Float => "single precision, as computed",
        }
    }
}

/// The file as bytes, the same for every number of threads.
///
/// # Errors
/// Errors of the encoder; none is known for a valid atlas.
pub fn to_bytes(atlas: &Atlas, provenance: &Provenance, samples: Samples) -> Result<Vec<u8>, AtlasError> {
    let headers: Headers = (0..LEVELS).map(|k| header(k, atlas, provenance, samples)).collect();
    let requirements = MetaData::validate(&headers, true).map_err(from_exr)?;

    let mut bytes = Vec::new();
    (|| {
        magic_number::write(&mut bytes)?;
        requirements.write(&mut bytes)?;
        for header in &headers {
            // the encoder keeps own attributes in a hash map, whose order differs from run to run
            let mut sorted: Vec<_> = header.all_named_attributes().collect();
            sorted.sort_unstable_by(|a, b| a.0.cmp(b.0));
            for (name, value) in sorted {
                attribute::write(name, &value, &mut bytes)?;
            }
            sequence_end::write(&mut bytes)?;
        }
        sequence_end::write(&mut bytes)
    })()
    .map_err(from_exr)?;

    let blocks: Vec<_> = ::exr::block::enumerate_ordered_header_block_indices(&headers).collect();
    let chunks: Vec<Vec<u8>> = blocks
        .par_iter()
        .map(|&(_, index)| {
            let data = block_data(atlas, samples, &headers[index.layer], index);
            let mut chunk = Vec::new();
            UncompressedBlock { index, data }.compress_to_chunk(&headers)?.write(&mut chunk, headers.len())?;
            Ok(chunk)
        })
        .collect::<Result<_, ExrError>>()
        .map_err(from_exr)?;

    let mut offset = bytes.len() + 8 * chunks.len();
    for chunk in &chunks {
        bytes.extend((offset as u64).to_le_bytes());
        offset += chunk.len();
    }
    bytes.extend(chunks.into_iter().flatten());
    Ok(bytes)
}

/// Writes the file; see [`to_bytes`].
///
/// # Errors
/// [`AtlasError::Io`] if `output` refuses.
pub fn write(
    atlas: &Atlas,
    provenance: &Provenance,
    samples: Samples,
    mut output: impl Write,
) -> Result<(), AtlasError> {
    Ok(output.write_all(&to_bytes(atlas, provenance, samples)?)?)
}

fn header(k: usize, atlas: &Atlas, provenance: &Provenance, samples: Samples) -> Header {
    let mut names = atlas.channels().names().to_vec();
    names.sort_unstable();
    let channels = names.into_iter().map(|name| ChannelDescription::new(name, samples.sample_type(), false)).collect();
    let text = |value: &str| Text::from_slice_unchecked(value.as_bytes());
    let mut own = LayerAttributes::named(layer_name(k).as_str());
    own.software_name = Some(text(&provenance.program));
    for (key, value) in attributes(atlas, provenance, samples.encoding()) {
        own.other.insert(key.into(), AttributeValue::Text(text(&value)));
    }
    let (low, high) = match samples {
        Samples::Half => stored_range(atlas),
        Samples::Float => atlas.range(),
    };
    own.other.insert("brdfit.range".into(), AttributeValue::FloatVec2(Vec2(low, high)));
    Header::new(layer_name(k).as_str().into(), (level_size(k), level_size(k)), channels)
        .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_display_window(IntegerBounds::from_dimensions((SIZE, SIZE)))
        .with_attributes(own)
}

fn layer_name(k: usize) -> String {
    format!("level{k}")
}

/// The place of each channel of the file, which is sorted by name, in a texel.
fn places(header: &Header, channels: AtlasChannels) -> Option<Vec<usize>> {
    let place = |name: &Text| channels.names().iter().position(|known| name.eq(known));
    let places: Vec<usize> = header.channels.list.iter().map(|channel| place(&channel.name)).collect::<Option<_>>()?;
    (places.len() == channels.count()).then_some(places)
}

fn block_data(atlas: &Atlas, samples: Samples, header: &Header, index: ::exr::block::BlockIndex) -> Vec<u8> {
    let (level, count) = (atlas.level(index.layer), atlas.channels().count());
    let places = places(header, atlas.channels()).unwrap_or_default();
    let mut bytes = Vec::with_capacity(index.pixel_size.area() * header.channels.bytes_per_pixel);
    for row in index.pixel_position.y()..index.pixel_position.y() + index.pixel_size.height() {
        let row = &level.texels()[row * level.size() * count..][..level.size() * count];
        for &place in &places {
            let values = row.iter().skip(place).step_by(count);
            match samples {
                Samples::Half => bytes.extend(values.flat_map(|&value| f16_rounded_up(value).to_ne_bytes())),
                Samples::Float => bytes.extend(values.flat_map(|value| value.to_ne_bytes())),
            }
        }
    }
    bytes
}

/// Reads a whole file from `input`; see [`from_bytes`].
///
/// # Errors
/// [`AtlasError::Io`] if `input` fails, and the errors of [`from_bytes`].
pub fn read(input: impl Read) -> Result<(Atlas, Provenance), AtlasError> {
    from_bytes(&read_all(input)?)
}

/// Reads a file that [`to_bytes`] wrote, or another program in the same structure (uncompressed, RLE or ZIP).
///
/// # Errors
/// [`AtlasError::WrongFormat`] if this is no OpenEXR file, [`AtlasError::Unsupported`] if it is another image than an
/// atlas, [`AtlasError::Damaged`] if it is incomplete, holds values that no atlas has, or levels that are not the maximum of
/// the level before.
pub fn from_bytes(bytes: &[u8]) -> Result<(Atlas, Provenance), AtlasError> {
    if !bytes.starts_with(&magic_number::BYTES) {
        let why = format!("{} bytes without the signature 76 2f 31 01", bytes.len());
        return Err(AtlasError::WrongFormat { expected: "an OpenEXR", why });
    }
    let reader = ::exr::block::read(std::io::Cursor::new(bytes), false).map_err(from_exr)?;
    let headers = reader.headers();
    if headers.len() != LEVELS {
        return Err(AtlasError::unsupported(format!("{} parts instead of {LEVELS}", headers.len())));
    }
    let channels = if headers[0].channels.list.len() == 1 { AtlasChannels::Max } else { AtlasChannels::Rgba };
    for (k, header) in headers.iter().enumerate() {
        check_part(k, header, channels)?;
    }
    let attributes = &headers[0].own_attributes;
    let as_string = |text: &Text| String::from_utf8_lossy(text.bytes()).into_owned();
    let (layout, provenance) = from_attributes(|key| match attributes.other.get(&Text::from(key)) {
        Some(AttributeValue::Text(text)) => Some(as_string(text)),
        _ => None,
    })?;

    let chunks = reader.all_chunks(true).map_err(from_exr)?;
    let meta = chunks.meta_data().clone();
    let chunks: Vec<Chunk> = chunks.collect::<Result<_, _>>().map_err(from_exr)?;
    let blocks: Vec<UncompressedBlock> = chunks
        .into_par_iter()
        .map(|chunk| UncompressedBlock::decompress_chunk(chunk, &meta, false))
        .collect::<Result<_, _>>()
        .map_err(from_exr)?;

    // NaN marks what no block has filled; the check of the values refuses it
    let filled = |k| vec![f32::NAN; level_size(k) * level_size(k) * channels.count()];
    let mut levels: Vec<Vec<f32>> = (0..LEVELS).map(filled).collect();
    for block in &blocks {
        fill(&mut levels[block.index.layer], block, &meta.headers[block.index.layer], channels);
    }
    Ok((atlas_of_levels(layout, channels, levels)?, provenance))
}

fn check_part(k: usize, header: &Header, channels: AtlasChannels) -> Result<(), AtlasError> {
    let fail = |why: String| Err(AtlasError::unsupported(format!("part {k} {why}")));
    let (name, size) = (layer_name(k), level_size(k));
    if header.own_attributes.layer_name.as_ref().is_none_or(|text| !text.eq(&name)) {
        return fail(format!("is not called {name}"));
    }
    if header.layer_size != Vec2(size, size) || header.own_attributes.layer_position != Vec2(0, 0) {
        let Vec2(width, height) = header.layer_size;
        return fail(format!("has {width} x {height} texels where {size} x {size} from (0, 0) are expected"));
    }
    if places(header, channels).is_none() {
        return fail("has other channels than max, or R, G, B and max".to_owned());
    }
    let plain = |channel: &ChannelDescription| {
        channel.sampling == Vec2(1, 1) && matches!(channel.sample_type, SampleType::F16 | SampleType::F32)
    };
    if !header.channels.list.iter().all(plain) {
        return fail("has subsampled or integer channels".to_owned());
    }
    let lossless = matches!(
        header.compression,
        Compression::Uncompressed | Compression::RLE | Compression::ZIP1 | Compression::ZIP16
    );
    if header.deep || header.blocks != BlockDescription::ScanLines || !lossless {
        return fail(format!("is deep, tiled or has {} instead of none, RLE or ZIP", header.compression));
    }
    Ok(())
}

/// Copies a block into its level.
fn fill(level: &mut [f32], block: &UncompressedBlock, header: &Header, channels: AtlasChannels) {
    let (count, width) = (channels.count(), header.layer_size.width());
    let places = places(header, channels).unwrap_or_default();
    let mut bytes = block.data.as_slice();
    let rows = level.chunks_exact_mut(width * count).skip(block.index.pixel_position.y());
    for row in rows.take(block.index.pixel_size.height()) {
        for (channel, &place) in header.channels.list.iter().zip(&places) {
            let (line, rest) = bytes.split_at(width * channel.sample_type.bytes_per_sample());
            bytes = rest;
            let texels = row.iter_mut().skip(place).step_by(count);
            if channel.sample_type == SampleType::F16 {
                let values = line.chunks_exact(2).map(|pair| f16::from_ne_bytes([pair[0], pair[1]]).to_f32());
                texels.zip(values).for_each(|(texel, value)| *texel = value);
            } else {
                let values = line.chunks_exact(4).map(|quad| f32::from_ne_bytes([quad[0], quad[1], quad[2], quad[3]]));
                texels.zip(values).for_each(|(texel, value)| *texel = value);
            }
        }
    }
}

fn from_exr(error: ExrError) -> AtlasError {
    match error {
        ExrError::Io(source) => AtlasError::Io(source),
        ExrError::NotSupported(why) => AtlasError::unsupported(why),
        ExrError::Invalid(why) => AtlasError::damaged(why),
        ExrError::Aborted => AtlasError::damaged("the decoder gave up"),
    }
}
