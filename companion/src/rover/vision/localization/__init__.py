"""Where the rover is: frames laid on the ground, keyframes, PnP, the pose filter."""
