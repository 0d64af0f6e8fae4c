//! Tests of the program from outside: what goes in, what comes out, and how it ends.

mod atlas;
mod batch;
mod documents;
mod fit;
mod help;
mod kill;
mod malformed;
mod program;
mod synth;
