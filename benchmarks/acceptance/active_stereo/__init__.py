"""A slow reference for active stereo: two infrared images with the projector's dots, drawn and matched."""
