"""What stands in a folder is replaced by other content on request only."""

from pathlib import Path

import pytest

from tests.dataset.toy import make_dataset
from warehouse_sim.cli.checks import write_beside, write_one
from warehouse_sim.cli.main import main
from warehouse_sim.errors import OutputError

HEADER = "scene_id,im_id,obj_id,score,R,t,time\n"
ROW = "{scene},0,1,1.0,1 0 0 0 1 0 0 0 1,0 0 2000,0.1\n"


def test_a_file_stays_where_another_would_replace_it(tmp_path: Path) -> None:
    page = tmp_path / "page.html"

    def write(text: str, overwrite: bool = False) -> Path:
        def made(path: Path) -> Path:
            path.write_text(text)
            return path

        return write_one(page, made, overwrite)

    assert write("a") == page
    assert write("a") == page
    with pytest.raises(OutputError, match=r"page\.html: is there with other content.*--overwrite"):
        write("b")
    assert page.read_text() == "a"
    write("b", overwrite=True)
    assert page.read_text() == "b"


def test_a_folder_keeps_files_that_others_would_replace(tmp_path: Path) -> None:
    folder = tmp_path / "scores"

    def write(text: str, overwrite: bool = False) -> Path:
        def made(path: Path) -> Path:
            path.mkdir(exist_ok=True)
            (path / "first.csv").write_text("same")
            (path / "scores.json").write_text(text)
            return path / "scores.json"

        return write_beside(folder, made, overwrite)

    write("a")
    (folder / "note.txt").write_text("mine")
    write("a")
    with pytest.raises(OutputError, match=r"scores\.json: is there with other content"):
        write("b")
    assert (folder / "scores.json").read_text() == "a"
    assert write("b", overwrite=True).read_text() == "b"
    assert (folder / "note.txt").read_text() == "mine"


def test_scores_and_pages_of_an_earlier_run_stay(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    make_dataset(Path("data"))
    Path("a.csv").write_text(HEADER)
    Path("b.csv").write_text(HEADER + ROW.format(scene=0))

    def run(line: str) -> tuple[int, str]:
        code = main(line.split())
        return code, capsys.readouterr().err

    scored = "evaluate {}.csv --data data --split all --out scores"
    reported = "report data scores --out page.html"
    assert run(scored.format("a"))[0] == run(scored.format("a"))[0] == 0
    assert run(reported)[0] == run(reported)[0] == 0
    before = Path("scores/scores.json").read_bytes()
    code, message = run(scored.format("b"))
    assert code == 2
    assert "is there with other content; name another --out, or add --overwrite" in message
    assert Path("scores/scores.json").read_bytes() == before
    assert run(f"{scored.format('b')} --overwrite")[0] == 0
    assert Path("scores/scores.json").read_bytes() != before
    code, message = run(reported)
    assert code == 2
    assert "page.html: is there with other content" in message
    assert run(f"{reported} --overwrite")[0] == 0
