"""What steps of a training draw from: arrays on disk, streams, their order."""
