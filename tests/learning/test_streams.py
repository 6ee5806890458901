from collections import Counter

from warehouse_sim.learning.streams import BatchStream


def stream(first: int, last: int, samples: int = 10, batch: int = 4) -> BatchStream:
    return BatchStream(samples, batch, 3, lambda: first, lambda step: step >= last)


def test_every_pass_holds_every_sample_once() -> None:
    flat = [index for batch in stream(0, 15) for index in batch.tolist()]
    assert len(flat) == 60
    for start in range(0, 60, 10):
        assert Counter(flat[start : start + 10]) == Counter(range(10))
    assert flat[:10] != flat[10:20]


def test_a_resumed_stream_goes_on_where_the_first_stopped() -> None:
    whole = [batch.tolist() for batch in stream(0, 12)]
    parts = [batch.tolist() for first, last in ((0, 5), (5, 12)) for batch in stream(first, last)]
    assert parts == whole


def test_a_batch_may_be_larger_than_the_data() -> None:
    (batch,) = stream(0, 1, samples=3, batch=7)
    counts = Counter(batch.tolist())
    assert sorted(counts) == [0, 1, 2]
    assert max(counts.values()) == 3
