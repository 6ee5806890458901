"""Run every rule of NVIDIA's asset validator on a stage; print, as JSON, how often each rule says what."""

import json
import sys
from collections import Counter

from omni.asset_validator import IssueSeverity, ValidationEngine

issues = ValidationEngine().validate(sys.argv[1]).issues()
bad = (IssueSeverity.ERROR, IssueSeverity.FAILURE)
counts = Counter(("bad" if item.severity in bad else "note", item.rule.__name__) for item in issues)
print(json.dumps({" ".join(key): number for key, number in counts.items()}))
