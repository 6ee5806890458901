"""What a dataset says of its scenes, observations and sensors beside the files of its formats."""
