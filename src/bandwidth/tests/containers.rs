//! EXR and KTX2 files of an atlas: round trips, the layout of the bytes, and inputs that are wrong.

use brdfit_bandwidth::exr::Samples;
use brdfit_bandwidth::sidecar::{
    AtlasDocument, AtlasOptions, AtlasStatistics, FileContent, FileEntry, Provenance, Source, TileCount,
};
use brdfit_bandwidth::{Atlas, AtlasChannels, AtlasError, LEVELS, Layout, SIZE, exr, f16_rounded_up, ktx2, level_size};
use half::f16;
use rayon::prelude::*;

/// Values of the full range without any pattern in the upper eighth, regular ones below; most are no halves.
fn atlas(layout: Layout, channels: AtlasChannels) -> Atlas {
    let value = |n: usize| match n / (SIZE * SIZE / 2) {
        0 => f32::from_bits((n as u32).wrapping_mul(0x9E37_79B9) % 0x477F_E001),
        _ => 1e-3 * (n % 997) as f32,
    };
    let texel = |n: usize| match channels {
        AtlasChannels::Max => vec![value(4 * n)],
        AtlasChannels::Rgba => {
            let [r, g, b] = [value(4 * n), value(4 * n + 1), value(4 * n + 2)];
            vec![r, g, b, r.max(g).max(b)]
        }
    };
    Atlas::from_level0(layout, channels, (0..SIZE * SIZE).flat_map(texel).collect()).unwrap()
}

fn flat() -> Atlas {
    Atlas::from_level0(Layout::Isotropic, AtlasChannels::Max, vec![0.75; SIZE * SIZE]).unwrap()
}

fn provenance() -> Provenance {
    let source = Source { name: "Grün".to_owned(), sha256: Some("ab".repeat(32)), kind: "merl".to_owned() };
    Provenance { program: "brdfit 0.1.0".to_owned(), source }
}

fn variants() -> Vec<Atlas> {
    let pair = |layout| [AtlasChannels::Max, AtlasChannels::Rgba].map(|channels| atlas(layout, channels));
    [Layout::Isotropic, Layout::Hemisphere].into_iter().flat_map(pair).collect()
}

#[test]
fn round_trips_are_exact() {
    for atlas in variants() {
        let provenance = provenance();
        let half = exr::to_bytes(&atlas, &provenance, Samples::Half).unwrap();
        let float = exr::to_bytes(&atlas, &provenance, Samples::Float).unwrap();
        assert_eq!(exr::from_bytes(&half).unwrap(), (atlas.rounded_up(), provenance.clone()));
        assert_eq!(exr::from_bytes(&float).unwrap(), (atlas.clone(), provenance.clone()));
        let bytes = ktx2::to_bytes(&atlas, &provenance);
        assert_eq!(ktx2::from_bytes(&bytes).unwrap(), (atlas.rounded_up(), provenance));
    }
}

#[test]
fn files_of_rounded_atlases_are_the_same() {
    let (atlas, provenance) = (atlas(Layout::Isotropic, AtlasChannels::Max), provenance());
    let rounded = atlas.rounded_up();
    assert_eq!(ktx2::to_bytes(&atlas, &provenance), ktx2::to_bytes(&rounded, &provenance));
    let exr = |atlas| exr::to_bytes(atlas, &provenance, Samples::Half).unwrap();
    assert_eq!(exr(&atlas), exr(&rounded));
}

#[test]
fn bytes_do_not_depend_on_threads_or_run() {
    let (atlas, provenance) = (atlas(Layout::Isotropic, AtlasChannels::Rgba), provenance());
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| exr::to_bytes(&atlas, &provenance, Samples::Half).unwrap())
    };
    let one = with(1);
    assert!(one == with(5));

    let mut written = Vec::new();
    exr::write(&atlas, &provenance, Samples::Half, &mut written).unwrap();
    assert!(one == written);
    assert_eq!(exr::read(one.as_slice()).unwrap().0, atlas.rounded_up());
}

#[test]
fn source_without_hash() {
    let mut provenance = provenance();
    provenance.source = Source { name: String::new(), sha256: None, kind: "fit".to_owned() };
    let flat = flat();
    assert_eq!(ktx2::read(ktx2::to_bytes(&flat, &provenance).as_slice()).unwrap().1, provenance);
    let exr = exr::to_bytes(&flat, &provenance, Samples::Half).unwrap();
    assert_eq!(exr::from_bytes(&exr).unwrap().1, provenance);
}

/// Attributes of each part are sorted by name, so that no hash map decides about the order of the bytes.
#[test]
fn exr_headers_as_bytes() {
    let bytes = exr::to_bytes(&flat(), &provenance(), Samples::Half).unwrap();
    assert_eq!(bytes[..8], [0x76, 0x2F, 0x31, 0x01, 2, 0x10, 0, 0], "multi-part, short names");
    let text = |at: usize| {
        let length = bytes[at..].iter().position(|&byte| byte == 0).unwrap();
        (std::str::from_utf8(&bytes[at..at + length]).unwrap(), at + length + 1)
    };
    let mut at = 8;
    for k in 0..LEVELS {
        let mut names = Vec::new();
        while bytes[at] != 0 {
            let (name, kind_at) = text(at);
            let (kind, size_at) = text(kind_at);
            let size = u32_at(&bytes, size_at) as usize;
            let value = &bytes[size_at + 4..][..size];
            at = size_at + 4 + size;
            let int = |n: usize| u32_at(value, 4 * n);
            match name {
                "name" => assert_eq!((kind, value), ("string", format!("level{k}").as_bytes())),
                "type" => assert_eq!(value, b"scanlineimage"),
                "compression" => assert_eq!(value, [3], "ZIP, 16 lines"),
                "displayWindow" => assert_eq!([int(0), int(1), int(2), int(3)], [0, 0, 1023, 1023]),
                "dataWindow" => {
                    let last = level_size(k) as u32 - 1;
                    assert_eq!([int(0), int(1), int(2), int(3)], [0, 0, last, last]);
                }
                "channels" => assert_eq!(value[..8], [b'm', b'a', b'x', 0, 1, 0, 0, 0], "half"),
                "brdfit.units" => assert_eq!((kind, value), ("string", &b"cycles per radian"[..])),
                "brdfit.range" => assert_eq!((kind, int(0), int(1)), ("v2f", 0x3F40_0000, 0x3F40_0000)),
                _ => {}
            }
            names.push(name);
        }
        at += 1;
        assert!(names.is_sorted() && names.len() == 22, "{names:?}");
    }
    assert_eq!(bytes[at], 0, "end of the headers");
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

fn u64_at(bytes: &[u8], at: usize) -> usize {
    usize::try_from(u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())).unwrap()
}

/// The header of a KTX2 file against the numbers of the specification, read by hand.
#[test]
fn ktx2_as_bytes() {
    for (channels, vk_format, texel) in [(AtlasChannels::Max, 76, 2), (AtlasChannels::Rgba, 97, 8)] {
        let atlas = atlas(Layout::Isotropic, channels);
        let bytes = ktx2::to_bytes(&atlas, &provenance());
        assert_eq!(bytes[..12], [0xAB, b'K', b'T', b'X', b' ', b'2', b'0', 0xBB, b'\r', b'\n', 0x1A, b'\n']);
        let fields: Vec<u32> = (12..48).step_by(4).map(|at| u32_at(&bytes, at)).collect();
        assert_eq!(fields, [vk_format, 2, 1024, 1024, 0, 0, 1, 7, 0]);
        let (dfd, dfd_length) = (u32_at(&bytes, 48) as usize, u32_at(&bytes, 52) as usize);
        let (kvd, kvd_length) = (u32_at(&bytes, 56) as usize, u32_at(&bytes, 60) as usize);
        assert_eq!((dfd, kvd, bytes[64..80].iter().max()), (80 + 7 * 24, dfd + dfd_length, Some(&0)));

        // basic descriptor block, version 2: RGBSDA, primaries unspecified, linear, one 1 x 1 block, signed float samples
        let samples = texel / 2;
        let mut words =
            vec![dfd_length as u32, 0, 2 | ((dfd_length as u32 - 4) << 16), 1 | (1 << 16), 0, texel as u32, 0];
        for (n, channel) in [0, 1, 2, 15].into_iter().enumerate().take(samples) {
            words.extend([
                (16 * n as u32) | (15 << 16) | ((0xC0 | channel) << 24),
                0,
                (-1.0_f32).to_bits(),
                1.0_f32.to_bits(),
            ]);
        }
        let found: Vec<u32> = (dfd..kvd).step_by(4).map(|at| u32_at(&bytes, at)).collect();
        assert_eq!(found, words);

        let mut at = kvd;
        let mut keys = Vec::new();
        while at < kvd + kvd_length {
            let length = u32_at(&bytes, at) as usize;
            let entry = std::str::from_utf8(&bytes[at + 4..at + 4 + length]).unwrap();
            let (key, value) = entry.split_once('\0').unwrap();
            let value = value.strip_suffix('\0').unwrap();
            match key {
                "KTXorientation" => assert_eq!(value, "rd"),
                "KTXwriter" => assert_eq!(value, "brdfit 0.1.0"),
                "brdfit.layout" => assert_eq!(value, "isotropic"),
                "brdfit.range" => assert_eq!(value, format!("0 {}", atlas.rounded_up().range().1)),
                "brdfit.source.name" => assert_eq!(value, "Grün"),
                _ => {}
            }
            keys.push(key);
            at = (at + 4 + length).next_multiple_of(4);
        }
        assert_eq!(at, kvd + kvd_length);
        assert!(keys.is_sorted() && keys.len() == 12, "{keys:?}");

        let mut end = at;
        for k in (0..LEVELS).rev() {
            let [offset, length, uncompressed] = [0, 8, 16].map(|field| u64_at(&bytes, 80 + 24 * k + field));
            assert_eq!((length, uncompressed), (level_size(k).pow(2) * texel, length));
            assert_eq!(offset, end.next_multiple_of(texel.max(4)), "level {k}, smallest first");
            assert!(bytes[end..offset].iter().all(|&padding| padding == 0));
            let data =
                bytes[offset..offset + length].chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
            assert!(data.eq(atlas.level(k).texels().iter().map(|&value| f16_rounded_up(value).to_bits())), "level {k}");
            end = offset + length;
        }
        assert_eq!(end, bytes.len());
    }
}

type Reader = fn(&[u8]) -> Result<(Atlas, Provenance), AtlasError>;

#[test]
fn truncated_files() {
    let flat = flat();
    let exr = exr::to_bytes(&flat, &provenance(), Samples::Half).unwrap();
    let ktx2 = ktx2::to_bytes(&flat, &provenance());
    for (reader, bytes) in [(exr::from_bytes as Reader, exr), (ktx2::from_bytes as Reader, ktx2)] {
        let mut lengths: Vec<usize> = (0..bytes.len().min(4000)).step_by(7).collect();
        lengths.extend((4000..bytes.len()).step_by(bytes.len() / 50));
        lengths.extend(bytes.len() - 9..bytes.len());
        lengths.into_par_iter().for_each(|length| match reader(&bytes[..length]).unwrap_err() {
            AtlasError::WrongFormat { .. } => assert!(length < 12),
            AtlasError::Damaged { .. } => {}
            other => panic!("{length} bytes: {other}"),
        });
    }
}

/// Damage anywhere in the first parts of a file is refused or without consequence for texels and layout.
#[test]
fn flipped_bytes() {
    let flat = flat();
    let exr = exr::to_bytes(&flat, &provenance(), Samples::Half).unwrap();
    let ktx2 = ktx2::to_bytes(&flat, &provenance());
    // the first part of the EXR file, and the end of the last part with the offset tables and the first chunks
    let tables = exr.windows(6).rposition(|window| window == b"level6").unwrap();
    let places = (0..2600).step_by(29).chain((tables..tables + 1200).step_by(31));
    flip(exr::from_bytes, &exr, &flat, places);
    flip(ktx2::from_bytes, &ktx2, &flat, (0..350).chain((350..3200).step_by(61)));
}

fn flip(reader: Reader, bytes: &[u8], flat: &Atlas, places: impl Iterator<Item = usize>) {
    let places: Vec<usize> = places.collect();
    places.into_par_iter().for_each(|at| {
        let mask = [0x01, 0x80, 0xFF][at % 3];
        let mut bytes = bytes.to_vec();
        bytes[at] ^= mask;
        if let Ok((atlas, _)) = reader(&bytes) {
            assert!(atlas == *flat, "byte {at} xor {mask:#x}");
        }
    });
}

fn ktx2_message(change: impl FnOnce(&mut Vec<u8>)) -> String {
    let mut bytes = ktx2::to_bytes(&flat(), &provenance());
    change(&mut bytes);
    ktx2::from_bytes(&bytes).unwrap_err().to_string()
}

fn set(at: usize, value: u32) -> impl FnOnce(&mut Vec<u8>) {
    move |bytes| bytes[at..at + 4].copy_from_slice(&value.to_le_bytes())
}

/// Sets the first texel of a level of the one-channel KTX2 file.
fn texel(k: usize, value: f16) -> impl FnOnce(&mut Vec<u8>) {
    move |bytes| {
        let offset = u64_at(bytes, 80 + 24 * k);
        bytes[offset..offset + 2].copy_from_slice(&value.to_le_bytes());
    }
}

#[test]
fn what_is_wrong_with_a_ktx2_file() {
    for (message, expected) in [
        (ktx2_message(|bytes| bytes.clear()), "not a KTX2 file (0 bytes without the signature"),
        (ktx2_message(|bytes| bytes[5] = b'1'), "not a KTX2 file"),
        (ktx2_message(|bytes| bytes.truncate(60)), "truncated: the header ends at byte 80, the file at byte 60"),
        (ktx2_message(set(12, 37)), "vkFormat 37 instead of 76"),
        (ktx2_message(set(16, 4)), "typeSize is 4 instead of 2"),
        (ktx2_message(set(20, 512)), "pixelWidth is 512 instead of 1024"),
        (ktx2_message(set(32, 2)), "layerCount is 2 instead of 0"),
        (ktx2_message(set(36, 6)), "faceCount is 6 instead of 1"),
        (ktx2_message(set(40, 11)), "levelCount is 11 instead of 7"),
        (ktx2_message(set(44, 2)), "supercompressionScheme is 2 instead of 0"),
        (ktx2_message(set(12, 97)), "data format descriptor contradicts"),
        (ktx2_message(set(48, u32::MAX)), "truncated: the data format descriptor"),
        (ktx2_message(set(60, u32::MAX)), "truncated: the key/value data"),
        (ktx2_message(set(88, 8)), "level 0 has 8 bytes instead of 2097152"),
        (ktx2_message(set(80 + 24 + 4, u32::MAX)), "truncated: level 1 ends at byte"),
        (ktx2_message(|bytes| bytes.truncate(bytes.len() - 1)), "truncated: level 0 ends at byte"),
        (ktx2_message(texel(0, f16::NAN)), "level 0, row 0, column 0, channel max is NaN, not a bandwidth"),
        (ktx2_message(texel(0, f16::from_f32(-1.0))), "is -1, not a bandwidth"),
        (
            ktx2_message(texel(0, f16::ONE)),
            "level 1, row 0, column 0, channel max is 0.75 where the maximum of level 0 is 1",
        ),
        (ktx2_message(texel(6, f16::NAN)), "level 6, row 0, column 0, channel max is NaN where the maximum"),
        (ktx2_message(replace(b"KTXorientation\0rd", b"KTXorientation\0ru")), "KTXorientation is 'ru'"),
        (ktx2_message(replace(b"brdfit.layout\0i", b"brdfit.layout\0I")), "brdfit.layout is 'Isotropic'"),
        (ktx2_message(replace(b"brdfit.units", b"brdfit.Units")), "it does not say brdfit.units"),
        (ktx2_message(replace(b"schema_version\x001", b"schema_version\x002")), "schema version 2, not 1"),
    ] {
        assert!(message.contains(expected), "{message}");
    }
}

/// Replaces the first occurrence of one text by another of the same length.
fn replace(from: &'static [u8], to: &'static [u8]) -> impl FnOnce(&mut Vec<u8>) {
    move |bytes| {
        let at = bytes.windows(from.len()).position(|window| window == from).unwrap();
        bytes[at..at + to.len()].copy_from_slice(to);
    }
}

#[test]
fn what_is_wrong_with_an_exr_file() {
    let bytes = exr::to_bytes(&flat(), &provenance(), Samples::Half).unwrap();
    let message = |change: fn(&mut Vec<u8>)| {
        let mut bytes = bytes.clone();
        change(&mut bytes);
        exr::from_bytes(&bytes).unwrap_err().to_string()
    };
    let ktx2 = ktx2::to_bytes(&flat(), &provenance());
    assert!(exr::from_bytes(&ktx2).unwrap_err().to_string().contains("not an OpenEXR file ("));
    for (message, expected) in [
        (message(Vec::clear), "not an OpenEXR file (0 bytes without"),
        (message(|bytes| replace(b"level0", b"LEVEL0")(bytes)), "part 0 is not called level0"),
        (message(|bytes| replace(b"max\0", b"mix\0")(bytes)), "part 0 has other channels than max"),
        (message(|bytes| replace(b"units\0", b"unitS\0")(bytes)), "it does not say brdfit.units"),
        (message(|bytes| replace(b"isotropic", b"ISOtropic")(bytes)), "brdfit.layout is 'ISOtropic'"),
        (
            message(|bytes| {
                replace(b"compression\0compression\0\x01\0\0\0\x03", b"compression\0compression\0\x01\0\0\0\x04")(bytes)
            }),
            "damaged",
        ),
        (message(|bytes| bytes.truncate(bytes.len() - 5)), "damaged"),
        // the data window of part 0, from 1023 to 2^30
        (message(|bytes| replace(b"\xFF\x03\0\0\xFF\x03\0\0", b"\0\0\0\x40\0\0\0\x40")(bytes)), ""),
    ] {
        assert!(message.contains(expected), "{message}");
    }
}

/// A sound EXR file of another program: one part, one channel.
#[test]
fn another_image() {
    use ::exr::prelude::*;
    let channel = SpecificChannels::build().with_channel("max").with_pixel_fn(|_| (0.0_f32,));
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_channels((16, 16), channel).write().to_buffered(&mut bytes).unwrap();
    let error = brdfit_bandwidth::exr::from_bytes(bytes.get_ref()).unwrap_err();
    assert!(matches!(error, AtlasError::Unsupported { .. }) && error.is_invalid_input());
    assert!(error.to_string().contains("1 parts instead of 7"), "{error}");
}

#[test]
fn document_round_trip() {
    let atlas = atlas(Layout::Hemisphere, AtlasChannels::Rgba);
    let options = AtlasOptions {
        rule: brdfit_bandwidth::Rule::Percentile(95.0),
        delta: 0.02,
        kappa: 0.471,
        reflections: true,
        finest_share: 0.0005,
        resolutions: vec![256, 512, 1024],
    };
    let statistics = AtlasStatistics {
        tiles_per_resolution: vec![TileCount { resolution: 256, tiles: 256 }],
        saturated_tiles: vec![3],
    };
    let files = vec![FileEntry { name: "a.atlas.exr".to_owned(), content: FileContent::ExrHalf }];
    let document = AtlasDocument::new(&atlas, provenance(), options, statistics, files);
    let text = serde_json::to_string(&document).unwrap();
    assert_eq!(serde_json::from_str::<AtlasDocument>(&text).unwrap(), document);

    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["layout"], "hemisphere");
    assert_eq!(json["channel_names"], serde_json::json!(["R", "G", "B", "max"]));
    assert_eq!(json["level_sizes"], serde_json::json!([1024, 512, 256, 128, 64, 32, 16]));
    assert_eq!(json["range"][1], atlas.rounded_up().range().1);
    assert_eq!(json["files"][0]["content"], "exr-half");

    let schema = serde_json::to_value(schemars::schema_for!(AtlasDocument)).unwrap();
    let required = schema["required"].as_array().unwrap();
    assert_eq!(required.len(), json.as_object().unwrap().len());
}
