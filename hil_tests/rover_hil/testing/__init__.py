"""What tests of the rigs share: plants on chosen ground, and a served rig with a bare client."""
