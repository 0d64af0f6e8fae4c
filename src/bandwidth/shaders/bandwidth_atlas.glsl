// Bandwidth atlas of a material: how fast f(i, .) varies around the outgoing direction o, in cycles per radian.
//
// The atlas is one texture with 7 levels, 1024 x 1024 to 16 x 16 texels: 16 x 16 tiles, one per incident direction, of 64 x 64
// texels at level 0 and of one at level 6. Each level is the maximum of 2 x 2 texels of the level before, never across tiles.
//   Isotropic layout:  tile t = column + 16 row holds theta_i = (t + 1/2)/256 pi/2 at phi_i = 0.
//   Hemisphere layout: tile (row, column) holds the direction i of texel (row, column) of the angular map with 16 x 16 texels.
//   Inside a tile:     o on the angular map, whose texel (row, column) of n x n is u = 2 (column + 1/2)/n - 1,
//                      v = 2 (row + 1/2)/n - 1, r = length(u, v), theta = min(r pi/2, arccos 0.02), phi = atan(v, u).
//
// Directions point away from the surface, in its frame: the normal is +z. They need not have length one. A direction below the
// rim, arccos 0.02 from the normal, counts as the one on the rim with the same azimuth, and the azimuth of the normal is zero.
//
// For GLSL from version 130, GLSL ES from 300 (there with "precision highp float; precision highp sampler2D;" before this
// text). Bind a sampler2D (R16F or RGBA16F, rows in the order of the file, highest level 6, any filter) and pass it on:
//   uniform sampler2D atlas;
//   float nu = bandwidth_nearest(atlas, bandwidth_isotropic(i, o), 0).x;
// Where textures come without samplers, define BANDWIDTH_ATLAS as texture2D before this text (GL_EXT_samplerless_texture_functions).
// An atlas of one channel holds the maximum over the colours in x, one of four channels the colours in x, y, z and their maximum in w.

#ifndef BANDWIDTH_ATLAS
#define BANDWIDTH_ATLAS sampler2D
#endif

const int BANDWIDTH_TILES = 16;
const int BANDWIDTH_TILE_SIZE = 64;
const int BANDWIDTH_LAST_LEVEL = 6;
const float BANDWIDTH_HALF_PI = 1.5707963;
// arccos 0.02
const float BANDWIDTH_RIM = 1.550795;
// sine of the polar angle below which a direction has no azimuth, per unit of length
const float BANDWIDTH_NO_AZIMUTH = 1e-12;

// Where a pair of directions lies: the tile, as (column, row), and the position inside it, from 0 to 1.
struct BandwidthPlace {
    ivec2 tile;
    vec2 position;
};

// Cosine and sine of the azimuth of d and, third, the length of its projection on the surface.
vec3 bandwidth_azimuth(vec3 d) {
    float across = sqrt(d.x * d.x + d.y * d.y);
    if (across < BANDWIDTH_NO_AZIMUTH) {
        return vec3(1.0, 0.0, across);
    }
    return vec3(d.x / across, d.y / across, across);
}

// Position of d on the angular map, (u, v) moved to 0 to 1.
vec2 bandwidth_angular_map(vec3 d) {
    vec3 azimuth = bandwidth_azimuth(d);
    float r = min(atan(azimuth.z, d.z), BANDWIDTH_RIM) / BANDWIDTH_HALF_PI;
    return 0.5 + 0.5 * r * azimuth.xy;
}

// Index of the part out of n that a position from 0 to 1 lies in.
int bandwidth_part(float position, int n) {
    return clamp(int(floor(position * float(n))), 0, n - 1);
}

// The place of (i, o) in an atlas of the isotropic layout.
BandwidthPlace bandwidth_isotropic(vec3 i, vec3 o) {
    vec3 azimuth = bandwidth_azimuth(i);
    float theta = atan(azimuth.z, i.z);
    int tile = bandwidth_part(theta / BANDWIDTH_HALF_PI, BANDWIDTH_TILES * BANDWIDTH_TILES);
    // o as seen from the azimuth of i
    vec3 turned = vec3(azimuth.x * o.x + azimuth.y * o.y, azimuth.x * o.y - azimuth.y * o.x, o.z);
    return BandwidthPlace(ivec2(tile % BANDWIDTH_TILES, tile / BANDWIDTH_TILES), bandwidth_angular_map(turned));
}

// The place of (i, o) in an atlas of the hemisphere layout.
BandwidthPlace bandwidth_hemisphere(vec3 i, vec3 o) {
    vec2 tile = bandwidth_angular_map(i);
    int column = bandwidth_part(tile.x, BANDWIDTH_TILES);
    int row = bandwidth_part(tile.y, BANDWIDTH_TILES);
    return BandwidthPlace(ivec2(column, row), bandwidth_angular_map(o));
}

// The texel that the place lies in; levels beyond the last one count as the last.
vec4 bandwidth_nearest(BANDWIDTH_ATLAS atlas, BandwidthPlace place, int level) {
    int used = clamp(level, 0, BANDWIDTH_LAST_LEVEL);
    int n = BANDWIDTH_TILE_SIZE >> used;
    ivec2 texel = ivec2(bandwidth_part(place.position.x, n), bandwidth_part(place.position.y, n));
    return texelFetch(atlas, place.tile * n + texel, used);
}

// Bilinear between the centres of the four nearest texels of the same tile; constant beyond the outermost centres.
vec4 bandwidth_bilinear(BANDWIDTH_ATLAS atlas, BandwidthPlace place, int level) {
    int used = clamp(level, 0, BANDWIDTH_LAST_LEVEL);
    int n = BANDWIDTH_TILE_SIZE >> used;
    float last = float(n - 1);
    float x = clamp(place.position.x * float(n) - 0.5, 0.0, last);
    float y = clamp(place.position.y * float(n) - 0.5, 0.0, last);
    ivec2 low = ivec2(int(floor(x)), int(floor(y)));
    ivec2 high = min(low + ivec2(1, 1), ivec2(n - 1, n - 1));
    ivec2 corner = place.tile * n;
    vec4 a = texelFetch(atlas, corner + low, used);
    vec4 b = texelFetch(atlas, corner + ivec2(high.x, low.y), used);
    vec4 c = texelFetch(atlas, corner + ivec2(low.x, high.y), used);
    vec4 d = texelFetch(atlas, corner + high, used);
    vec4 top = a + (b - a) * (x - floor(x));
    vec4 bottom = c + (d - c) * (x - floor(x));
    return top + (bottom - top) * (y - floor(y));
}
