//! What tables leave: the error over the volume, as the control interpolates, against the exact correction.
