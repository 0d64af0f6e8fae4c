//! Tests of the program from outside: what goes in, what comes out, and how it ends.

mod atlas;
mod batch;
mod documents;
mod fit;
mod help;
mod kill;
mod malformed;
mod models;
mod openexr;
mod program;
mod render;
mod render_malformed;
mod render_malformed_files;
mod rgl;
mod synth;
