"""Keys, hashes, tokens and attachments as rmw_zenoh writes them."""

import struct

import pytest

from mobius.bridge.messages import HEARD, TOPICS
from mobius.bridge.wire import (
    Attachment,
    Endpoint,
    Who,
    data_key,
    dds_name,
    endpoint_token,
    gid_of,
    node_token,
    pack_attachment,
    qos_string,
    type_hash,
    unpack_attachment,
)
from mobius.errors import InvalidInput

STRING = "std_msgs/msg/String"
WHO = Who(3, "1f0a", "mobius")
TYPES = sorted({t.type for t in TOPICS.values()} | {h.type for h in HEARD})


def test_the_hash_of_a_string_is_the_one_that_ros_prints():
    """``ros2 topic info -v`` on Jazzy shows it for std_msgs/msg/String."""
    assert type_hash(STRING) == (
        "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    )


def test_a_topic_is_a_key_that_ends_in_its_types_hash():
    key = data_key(3, "/left_gripper/wrench", "geometry_msgs/msg/WrenchStamped")
    assert key.startswith("3/left_gripper/wrench/geometry_msgs::msg::dds_::WrenchStamped_/RIHS01_")
    assert len(key.rpartition("RIHS01_")[2]) == 64


def test_tokens_have_the_parts_of_the_design_document():
    assert node_token(WHO) == "@ros2_lv/3/1f0a/0/0/NN/%/%/mobius"
    end = Endpoint(WHO, 5, "MP", "/left_gripper/wrench", STRING, latched=True)
    assert endpoint_token(end) == (
        "@ros2_lv/3/1f0a/0/5/MP/%/%/mobius/%left_gripper%wrench/std_msgs::msg::dds_::String_/"
        f"{type_hash(STRING)}/:1:,1:,:,:,,"
    )


def test_an_attachment_is_two_long_numbers_and_a_name_with_its_length():
    gid = bytes(range(16))
    data = pack_attachment(Attachment(7, 1_700_000_000_000_000_001, gid))
    assert data == struct.pack("<qq", 7, 1_700_000_000_000_000_001) + b"\x10" + gid
    assert unpack_attachment(data) == Attachment(7, 1_700_000_000_000_000_001, gid)


@pytest.mark.parametrize("data", [b"", b"x" * 32, b"x" * 33, b"x" * 34])
def test_what_is_no_attachment_is_refused(data):
    with pytest.raises(InvalidInput, match="expected 33 bytes"):
        unpack_attachment(data)


def test_every_endpoint_has_a_name_of_its_own():
    ends = [Endpoint(WHO, k, "MP", "/odom", STRING) for k in range(10)]
    assert len({gid_of(endpoint_token(e)) for e in ends}) == 10
    assert all(len(gid_of(endpoint_token(e))) == 16 for e in ends)


@pytest.mark.parametrize("kind", TYPES)
def test_another_implementation_computes_the_same_hash(kind, tmp_path, write_definitions):
    utils = pytest.importorskip(
        "zenoh_ros2_sdk.utils", reason="zenoh-ros2-sdk is not usable", exc_type=ImportError
    )
    write_definitions(tmp_path, [kind])

    def text(name: str) -> str:
        package, _, short = name.split("/")
        return (tmp_path / package / "msg" / f"{short}.msg").read_text()

    others = {
        "/".join((p.parts[-3], "msg", p.stem)): p.read_text() for p in tmp_path.rglob("*.msg")
    }
    others.pop(kind)
    assert utils.get_type_hash(kind, msg_definition=text(kind), dependencies=others) == (
        type_hash(kind)
    )


@pytest.mark.parametrize("latched", [False, True])
def test_another_implementation_writes_the_same_keys_and_reads_our_qos(latched):
    sdk = pytest.importorskip(
        "zenoh_ros2_sdk", reason="zenoh-ros2-sdk is not usable", exc_type=ImportError
    )
    from zenoh_ros2_sdk import entity, keyexpr, qos, utils

    assert sdk is not None
    kind = "sensor_msgs/msg/JointState"
    assert utils.ros2_to_dds_type(kind) == dds_name(kind)
    theirs = keyexpr.topic_keyexpr(3, "/joint_states", dds_name(kind), type_hash(kind))
    assert data_key(3, "/joint_states", kind) == theirs
    node = entity.NodeEntity(
        domain_id=3, session_id="1f0a", node_id=0, node_name="mobius", namespace="/"
    )
    assert keyexpr.node_liveliness_keyexpr(node) == node_token(WHO)
    end = entity.EndpointEntity(
        node=node, entity_id=5, kind=entity.EntityKind.PUBLISHER, name="/joint_states",
        dds_type_name=dds_name(kind), type_hash=type_hash(kind), qos=qos_string(latched=latched),
        gid=bytes(16),
    )  # fmt: skip
    ours = Endpoint(WHO, 5, "MP", "/joint_states", kind, latched)
    assert keyexpr.endpoint_liveliness_keyexpr(end) == endpoint_token(ours)
    read = qos.QosProfile.decode(qos_string(latched=latched))
    assert read.reliability is qos.QosReliability.RELIABLE
    assert (read.durability is qos.QosDurability.TRANSIENT_LOCAL) is latched
    assert read.history_depth == (1 if latched else 10)
