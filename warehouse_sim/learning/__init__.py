"""The engine that trains any network: loop, clock, order of samples, precision, averaging, records, run folder."""
