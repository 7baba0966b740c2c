"""Cross-verification of the UFL side against the hand-written solver."""
