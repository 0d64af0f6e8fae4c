// Bandwidth atlas of a material: how fast f(i, .) varies around the outgoing direction o, in cycles per radian.
//
// The atlas is one texture with 7 levels, 1024 x 1024 to 16 x 16 texels: 16 x 16 tiles, one per incident direction, of 64 x 64
// texels at level 0 and of one at level 6. Each level is the maximum of 2 x 2 texels of the level before, never across tiles.
//   Isotropic layout:  tile t = column + 16 row holds theta_i = (t + 1/2)/256 pi/2 at phi_i = 0.
//   Hemisphere layout: tile (row, column) holds the direction i of texel (row, column) of the angular map with 16 x 16 texels.
//   Inside a tile:     o on the angular map, whose texel (row, column) of n x n is u = 2 (column + 1/2)/n - 1,
//                      v = 2 (row + 1/2)/n - 1, r = length(u, v), theta = min(r pi/2, arccos 0.02), phi = atan2(v, u).
//
// Directions point away from the surface, in its frame: the normal is +z. They need not have length one. A direction below the
// rim, arccos 0.02 from the normal, counts as the one on the rim with the same azimuth, and the azimuth of the normal is zero.
//
// Bind a texture_2d<f32> (r16float or rgba16float, rows in the order of the file, no sampler) and pass it on:
//   @group(0) @binding(0) var atlas: texture_2d<f32>;
//   let nu = bandwidth_nearest(atlas, bandwidth_isotropic(i, o), 0u);
// An atlas of one channel holds the maximum over the colours in x, one of four channels the colours in x, y, z and their maximum in w.

const BANDWIDTH_TILES: i32 = 16;
const BANDWIDTH_TILE_SIZE: i32 = 64;
const BANDWIDTH_LAST_LEVEL: u32 = 6u;
const BANDWIDTH_HALF_PI: f32 = 1.5707963;
// arccos 0.02
const BANDWIDTH_RIM: f32 = 1.550795;
// sine of the polar angle below which a direction has no azimuth, per unit of length
const BANDWIDTH_NO_AZIMUTH: f32 = 1e-12;

// Where a pair of directions lies: the tile, as (column, row), and the position inside it, from 0 to 1.
struct BandwidthPlace {
    tile: vec2<i32>,
    position: vec2<f32>,
}

// Cosine and sine of the azimuth of d and, third, the length of its projection on the surface.
fn bandwidth_azimuth(d: vec3<f32>) -> vec3<f32> {
    let across = sqrt(d.x * d.x + d.y * d.y);
    if (across < BANDWIDTH_NO_AZIMUTH) {
        return vec3<f32>(1.0, 0.0, across);
    }
    return vec3<f32>(d.x / across, d.y / across, across);
}

// Position of d on the angular map, (u, v) moved to 0 to 1.
fn bandwidth_angular_map(d: vec3<f32>) -> vec2<f32> {
    let azimuth = bandwidth_azimuth(d);
    let r = min(atan2(azimuth.z, d.z), BANDWIDTH_RIM) / BANDWIDTH_HALF_PI;
    return 0.5 + 0.5 * r * azimuth.xy;
}

// Index of the part out of n that a position from 0 to 1 lies in.
fn bandwidth_part(position: f32, n: i32) -> i32 {
    return clamp(i32(floor(position * f32(n))), 0, n - 1);
}

// The place of (i, o) in an atlas of the isotropic layout.
fn bandwidth_isotropic(i: vec3<f32>, o: vec3<f32>) -> BandwidthPlace {
    let azimuth = bandwidth_azimuth(i);
    let theta = atan2(azimuth.z, i.z);
    let tile = bandwidth_part(theta / BANDWIDTH_HALF_PI, BANDWIDTH_TILES * BANDWIDTH_TILES);
    // o as seen from the azimuth of i
    let turned = vec3<f32>(azimuth.x * o.x + azimuth.y * o.y, azimuth.x * o.y - azimuth.y * o.x, o.z);
    return BandwidthPlace(vec2<i32>(tile % BANDWIDTH_TILES, tile / BANDWIDTH_TILES), bandwidth_angular_map(turned));
}

// The place of (i, o) in an atlas of the hemisphere layout.
fn bandwidth_hemisphere(i: vec3<f32>, o: vec3<f32>) -> BandwidthPlace {
    let tile = bandwidth_angular_map(i);
    let column = bandwidth_part(tile.x, BANDWIDTH_TILES);
    let row = bandwidth_part(tile.y, BANDWIDTH_TILES);
    return BandwidthPlace(vec2<i32>(column, row), bandwidth_angular_map(o));
}

// The texel that the place lies in; levels beyond the last one count as the last.
fn bandwidth_nearest(atlas: texture_2d<f32>, place: BandwidthPlace, level: u32) -> vec4<f32> {
    let used = min(level, BANDWIDTH_LAST_LEVEL);
    let n = BANDWIDTH_TILE_SIZE >> used;
    let texel = vec2<i32>(bandwidth_part(place.position.x, n), bandwidth_part(place.position.y, n));
    return textureLoad(atlas, place.tile * n + texel, i32(used));
}

// Bilinear between the centres of the four nearest texels of the same tile; constant beyond the outermost centres.
fn bandwidth_bilinear(atlas: texture_2d<f32>, place: BandwidthPlace, level: u32) -> vec4<f32> {
    let used = min(level, BANDWIDTH_LAST_LEVEL);
    let n = BANDWIDTH_TILE_SIZE >> used;
    let last = f32(n - 1);
    let x = clamp(place.position.x * f32(n) - 0.5, 0.0, last);
    let y = clamp(place.position.y * f32(n) - 0.5, 0.0, last);
    let low = vec2<i32>(i32(floor(x)), i32(floor(y)));
    let high = min(low + vec2<i32>(1, 1), vec2<i32>(n - 1, n - 1));
    let corner = place.tile * n;
    let a = textureLoad(atlas, corner + low, i32(used));
    let b = textureLoad(atlas, corner + vec2<i32>(high.x, low.y), i32(used));
    let c = textureLoad(atlas, corner + vec2<i32>(low.x, high.y), i32(used));
    let d = textureLoad(atlas, corner + high, i32(used));
    let top = a + (b - a) * (x - floor(x));
    let bottom = c + (d - c) * (x - floor(x));
    return top + (bottom - top) * (y - floor(y));
}
