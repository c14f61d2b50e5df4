//! Puts the chip's memory.x where the linker looks, names the linker scripts, and passes the commit on to the code.

use std::path::PathBuf;
use std::process::Command;
use std::{env, fs};

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let is_rp2040 = env::var_os("CARGO_FEATURE_RP2040").is_some();
    // None of them is called memory.x here: the linker would take that one from this folder for every chip.
    let memory = if is_rp2040 {
        "memory-rp2040.x"
    } else {
        "memory-rp2350.x"
    };
    fs::copy(memory, out.join("memory.x")).expect("OUT_DIR is writable");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rerun-if-changed={memory}");
    for argument in ["--nmagic", "-Tlink.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    if is_rp2040 {
        // The section of the second-stage boot loader.
        println!("cargo:rustc-link-arg-bins=-Tlink-rp.x");
    }

    println!("cargo:rerun-if-env-changed=ROVER_GIT_HASH");
    println!("cargo:rerun-if-changed=../../.git/HEAD");
    let commit = env::var("ROVER_GIT_HASH")
        .ok()
        .or_else(head)
        .unwrap_or_default();
    let first: String = commit
        .chars()
        .take_while(char::is_ascii_hexdigit)
        .take(8)
        .collect();
    println!("cargo:rustc-env=ROVER_GIT_HASH={first:0>8}");
}

/// The commit that is checked out, if this is a clone.
fn head() -> Option<String> {
    let output = Command::new("git")
        .args(["rev-parse", "HEAD"])
        .output()
        .ok()?;
    output
        .status
        .success()
        .then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}
