//! The sidecar of an atlas: source, mapping, units, options and statistics.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::atlas::f16_round_up::f16_rounded_up;
use crate::atlas::texture::{Atlas, AtlasChannels, Layout, Level, TILE, TILES, UNITS};
use crate::wavelet::spectrum::Rule;

/// Version of the document and of the attributes in EXR and KTX2 files; it rises when a program that reads the present one
/// could be misled.
pub const ATLAS_SCHEMA_VERSION: u32 = 1;

/// Origin of an atlas, recorded in every EXR and KTX2 file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Provenance {
    /// Program that computed the atlas, with its version.
    pub program: String,
    /// The material.
    pub source: Source,
}

/// The file that describes the material.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Source {
    /// File name without its folder and extension.
    pub name: String,
    /// SHA-256 of the whole file, lower-case hexadecimal; absent if it was not requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
    /// Kind of file: `fit` for the result of a fit, or the format of a measurement (`merl`, `rgl`).
    pub kind: String,
}

/// The atlas of one material. No NaN, no time, no host name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "brdfit bandwidth atlas")]
pub struct AtlasDocument {
    /// Version of this layout.
    pub schema_version: u32,
    /// Program that wrote it, with its version.
    pub program: String,
    /// The material.
    pub source: Source,
    /// Incident directions of the tiles.
    pub layout: Layout,
    /// Channels of a texel.
    pub channels: AtlasChannels,
    /// Names of a texel's values in their order: the channels of the EXR files; R, G, B, A in a KTX2 file.
    pub channel_names: Vec<String>,
    /// Texels along one side of a tile in level 0.
    pub tile_size: usize,
    /// Tiles along one side of the square atlas.
    pub tiles: usize,
    /// Texels along one side of the square atlas, for each level.
    pub level_sizes: Vec<usize>,
    /// Unit of the values.
    pub units: String,
    /// Smallest and largest stored value of level 0.
    pub range: [f32; 2],
    /// Encoding of the values in the files.
    pub encoding: String,
    /// The mapping between directions and texels.
    pub mapping: Mapping,
    /// All options that influenced the values.
    pub options: AtlasOptions,
    /// Statistics of the computation.
    pub statistics: AtlasStatistics,
    /// The files that hold the atlas.
    pub files: Vec<FileEntry>,
}

/// Relation of stored to computed values; the text of [`AtlasDocument::encoding`].
pub const ENCODING: &str = "half precision, rounded towards plus infinity: never below the computed value; \
                            exr-float: single precision, as computed";

impl AtlasDocument {
    /// The document of `atlas`, whose values are those before the rounding to half precision.
    #[must_use]
    pub fn new(
        atlas: &Atlas,
        provenance: Provenance,
        options: AtlasOptions,
        statistics: AtlasStatistics,
        files: Vec<FileEntry>,
    ) -> Self {
        let (low, high) = stored_range(atlas);
        Self {
            schema_version: ATLAS_SCHEMA_VERSION,
            program: provenance.program,
            source: provenance.source,
            layout: atlas.layout(),
            channels: atlas.channels(),
            channel_names: atlas.channels().names().iter().map(ToString::to_string).collect(),
            tile_size: TILE,
            tiles: TILES,
            level_sizes: atlas.levels().iter().map(Level::size).collect(),
            units: UNITS.to_owned(),
            range: [low, high],
            encoding: ENCODING.to_owned(),
            mapping: Mapping::new(atlas.layout()),
            options,
            statistics,
            files,
        }
    }
}

/// The range of an atlas after rounding up to half precision.
pub(crate) fn stored_range(atlas: &Atlas) -> (f32, f32) {
    let (low, high) = atlas.range();
    (f16_rounded_up(low).to_f32(), f16_rounded_up(high).to_f32())
}

/// The mapping between directions and texels. Directions point away from the surface, i to the light and o to the eye, in
/// radians: theta from the normal, phi around it. Every statement is a formula or a short sentence.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Mapping {
    /// Meaning of a value.
    pub value: String,
    /// Position of tile t.
    pub tile: String,
    /// The incident direction of a tile.
    pub incident: String,
    /// The tile of an incident direction.
    pub tile_of_incident: String,
    /// The outgoing direction of a texel of a tile: angular map, half-texel rule, first row.
    pub outgoing: String,
    /// Position of the incident direction and of its mirror direction in a tile.
    pub light: String,
    /// The texel of an outgoing direction.
    pub texel_of_outgoing: String,
    /// Relation of the levels to each other.
    pub levels: String,
}

impl Mapping {
    /// The statements for a layout.
    #[must_use]
    pub fn new(layout: Layout) -> Self {
        let absolute = layout == Layout::Hemisphere;
        let (azimuth, turn, light) = if absolute {
            (
                "phi_o",
                "phi = phi_o",
                "the light is at u = theta_i/(pi/2) cos phi_i, v = theta_i/(pi/2) sin phi_i; the mirror direction opposite",
            )
        } else {
            (
                "phi_o - phi_i",
                "turn o by -phi_i: phi = phi_o - phi_i",
                "the light is at phi = 0: u = theta_i/(pi/2), v = 0; the mirror direction is at u = -theta_i/(pi/2), v = 0",
            )
        };
        let (incident, tile_of_incident) = match layout {
            Layout::Isotropic => ("theta_i = (t + 1/2)/256 pi/2, any phi_i", "t = min(floor(256 theta_i/(pi/2)), 255)"),
            Layout::Hemisphere => (
                "a = 2 (tile column + 1/2)/16 - 1, b = 2 (tile row + 1/2)/16 - 1, \
                 theta_i = min(sqrt(a^2 + b^2) pi/2, arccos 0.02), phi_i = atan2(b, a)",
                "a = theta_i/(pi/2) cos phi_i, b = theta_i/(pi/2) sin phi_i, \
                 tile column = min(floor(8 (a + 1)), 15), tile row = min(floor(8 (b + 1)), 15)",
            ),
        };
        Self {
            value:
                "local bandwidth of f(i, .), without the cosine, over the outgoing directions, in cycles per radian: \
                    the largest in the area of the texel"
                    .to_owned(),
            tile: "t = tile column + 16 tile row; at level k a tile has n x n texels, n = 64/2^k, and begins at texel \
                   column n (tile column), texel row n (tile row) of the level; rows and columns count from 0, \
                   row 0 is the first in the file"
                .to_owned(),
            incident: incident.to_owned(),
            tile_of_incident: tile_of_incident.to_owned(),
            outgoing: format!(
                "angular map at the centre of the texel: u = 2 (column + 1/2)/n - 1, v = 2 (row + 1/2)/n - 1 \
                 (row 0 at v = -1), r = sqrt(u^2 + v^2), theta_o = min(r pi/2, arccos 0.02), {azimuth} = atan2(v, u)"
            ),
            light: light.to_owned(),
            texel_of_outgoing: format!(
                "limit theta_o to arccos 0.02; {turn}, u = theta_o/(pi/2) cos phi, v = theta_o/(pi/2) sin phi, \
                 column = min(floor(n (u + 1)/2), n - 1), row = min(floor(n (v + 1)/2), n - 1); bilinear look-ups stay \
                 inside the tile: n (u + 1)/2 and n (v + 1)/2 limited to 1/2 .. n - 1/2"
            ),
            levels: "a texel of level k + 1 is the maximum of 2 x 2 texels of level k, each channel on its own, never \
                     across tiles"
                .to_owned(),
        }
    }

    /// All statements in one text, for the attributes of image files.
    #[must_use]
    pub fn text(&self) -> String {
        format!(
            "value: {}. tile: {}. incident direction of a tile: {}. tile of an incident direction: {}. \
             outgoing direction of a texel: {}. light: {}. texel of an outgoing direction: {}. levels: {}.",
            self.value,
            self.tile,
            self.incident,
            self.tile_of_incident,
            self.outgoing,
            self.light,
            self.texel_of_outgoing,
            self.levels
        )
    }
}

/// All options that influence the values of an atlas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AtlasOptions {
    /// Rule by which a bandwidth follows from the energies per band.
    pub rule: Rule,
    /// A band is dropped at a pixel where it holds at most delta^2 of the energy there.
    pub delta: f64,
    /// Calibration: bandwidth is kappa times the percentile.
    pub kappa: f64,
    /// Whether the estimates are averaged over the reflections of the wavelet.
    pub reflections: bool,
    /// A lobe is refined to the next resolution where its finest level holds more than this share of its energy.
    pub finest_share: f64,
    /// Resolutions of the lobe images that were allowed, pixels along one side, increasing.
    pub resolutions: Vec<u32>,
}

/// Statistics of the computation of an atlas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AtlasStatistics {
    /// Number of tiles computed from lobe images of each resolution, increasing.
    pub tiles_per_resolution: Vec<TileCount>,
    /// Tiles t whose lobe was still too sharp for the highest resolution, increasing: their values are lower bounds.
    pub saturated_tiles: Vec<usize>,
}

/// Tiles that were taken from lobe images of one resolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct TileCount {
    /// Pixels along one side of the lobe image.
    pub resolution: u32,
    /// Number of tiles.
    pub tiles: usize,
}

/// One file that holds the atlas.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FileEntry {
    /// File name, in the folder of the document.
    pub name: String,
    /// Its content.
    pub content: FileContent,
}

/// Content of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FileContent {
    /// OpenEXR, one part per level, half precision.
    ExrHalf,
    /// OpenEXR, one part per level, single precision.
    ExrFloat,
    /// KTX2, mip levels in half precision.
    Ktx2Half,
    /// PNG preview of level 0; its values are not bandwidths.
    PngPreview,
}
