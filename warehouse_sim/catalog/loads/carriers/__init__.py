"""Carriers that are a unit load alone or with a pallet: boxes of mesh, roll containers, octabins, big bags, IBCs."""
