"""Whole images as networks see them: scaled once, encoded, kept on disk, composed again for each training step."""
