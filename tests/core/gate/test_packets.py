"""Packets stay whole, never wait, and nonsense is left out."""

import pytest

from core.gate.packets import AT_ONCE, packet_pair, packet_socket, parse_packet, send_packet, take_packets


def test_packets_arrive_whole_and_in_order() -> None:
    here, there = packet_pair()
    with here, there:
        for n in range(5):
            assert send_packet(here, {"n": n})
        assert take_packets(there) == ([{"n": n} for n in range(5)], True)
        assert take_packets(there) == ([], True)


def test_the_end_of_the_other_side_is_seen_after_its_last_words() -> None:
    here, there = packet_pair()
    with there:
        send_packet(here, {"n": 1})
        here.close()
        assert take_packets(there) == ([{"n": 1}], False)


def test_an_end_that_left_packets_unread_is_heard_to_its_last_words() -> None:
    here, there = packet_pair()
    with there:
        send_packet(there, {"unread": True})
        send_packet(here, {"n": 1})
        here.close()
        assert take_packets(there) == ([{"n": 1}], False)


def test_a_full_pipe_drops_and_does_not_wait() -> None:
    here, there = packet_pair()
    with here, there:
        sent = sum(send_packet(here, {"n": n, "much": "x" * 1000}) for n in range(5000))
        assert 10 < sent < 5000


def test_a_flood_is_taken_in_portions() -> None:
    here, there = packet_pair()
    with here, there:
        sent = 0
        while send_packet(here, {}):
            sent += 1
        taken, open_still = take_packets(there)
        assert open_still and len(taken) == min(sent, AT_ONCE)


def test_to_a_closed_end_nothing_goes() -> None:
    here, there = packet_pair()
    there.close()
    with here:
        assert not send_packet(here, {"n": 1})


def test_a_descriptor_becomes_an_end_again() -> None:
    here, there = packet_pair()
    with here, packet_socket(there.detach()) as end:
        send_packet(here, {"n": 1})
        assert take_packets(end) == ([{"n": 1}], True)


@pytest.mark.parametrize(
    "raw",
    [b"", b"{", b"[1]", b"1", b"null", b'{"v":NaN}', b'{"v":Infinity}', b'{"a":1,"a":2}', b"\xff\xfe", b"[" * 10000],
)
def test_nonsense_is_no_packet(raw: bytes) -> None:
    assert parse_packet(raw) is None
