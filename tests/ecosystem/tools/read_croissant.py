"""Read all records of a Croissant file by mlcroissant: read_croissant.py FILE."""

import json
import sys

import mlcroissant

data = mlcroissant.Dataset(sys.argv[1])
found = {}
for records in data.metadata.record_sets:
    rows = list(data.records(records.id))
    found[records.id] = [len(rows), list(rows[0][f"{records.id}/image"].size)]
print(json.dumps({"name": data.metadata.name, "records": found, "errors": sorted(data.metadata.issues.errors)}))
