"""What the rover is built from and runs on: every crate and package, its licence, and the bill of materials."""
