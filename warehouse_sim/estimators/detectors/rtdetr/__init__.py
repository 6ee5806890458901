"""RT-DETR v2 as the library transformers (Apache-2.0) has it, trained and used as the package's own detector is."""
