"""Check of the readings that no format holds."""

from warehouse_sim.dataset.checks.findings import Findings, compare_names
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.readings import read_reading
from warehouse_sim.errors import DatasetError


def readings(subject: Subject) -> Findings:
    """Each sensor of the manifest, and no other, has a file an observation with the arrays that the manifest says."""
    findings, sensors = Findings(), subject.manifest.contents.readings
    compare_names(findings, subject.layout.readings, set(sensors), "sensor")
    places = list(subject.observations())
    names = {subject.layout.reading("any", scene, observation).name for _, scene, observation in places}
    for name, contents in sensors.items():
        compare_names(findings, subject.layout.readings / name, names)
        for _, scene, observation in places:
            path = subject.layout.reading(name, scene, observation)
            try:
                read_reading(path, contents)
            except DatasetError as problem:
                findings.require(False, str(problem))
            findings.count += 1
    findings.examined = f"{findings.count} readings of {', '.join(sensors)}"
    return findings
