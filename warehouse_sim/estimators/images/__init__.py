"""Whole images as networks see them: scaled once, encoded, kept on disk, composed anew for each training step."""
