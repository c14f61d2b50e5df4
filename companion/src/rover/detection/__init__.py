"""From a thermal picture of the ground to places that may hold a mine (paper section 4)."""
