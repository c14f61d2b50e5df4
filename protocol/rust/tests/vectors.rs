//! The codec agrees with the golden vectors byte for byte.

use rover_protocol::{framing, messages, Message};
use serde_json::Value;

fn vectors(name: &str) -> Vec<Value> {
    let path = format!("{}/../vectors/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn bytes(hex: &Value) -> Vec<u8> {
    let hex = hex.as_str().unwrap();
    (0..hex.len())
        .step_by(2)
        .map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap())
        .collect()
}

/// What `{:?}` of the message with these values looks like.
fn shown(vector: &Value) -> String {
    let fields: Vec<String> = vector["values"]
        .as_object()
        .unwrap()
        .iter()
        .map(|(name, value)| format!("{name}: {value}").replace(',', ", "))
        .collect();
    let name = vector["message"].as_str().unwrap();
    format!("{name} {{ {} }}", fields.join(", "))
}

fn check<M: Message + std::fmt::Debug>(vector: &Value) {
    let payload = bytes(&vector["payload"]);
    let message = M::read(&payload).unwrap();
    assert_eq!(vector["identifier"], M::ID);
    assert_eq!(messages::length(M::ID), Some(payload.len()));
    assert_eq!(format!("{message:?}"), shown(vector));

    let mut out = [0xaa; 8];
    message.write(&mut out);
    assert_eq!(out[..M::LENGTH], payload);
    assert_eq!(out[M::LENGTH..], [0; 8][M::LENGTH..]);

    for wrong in (0..10).filter(|length| *length != M::LENGTH) {
        assert!(M::read(&[0; 10][..wrong]).is_none());
    }

    let mut wire = [0; framing::MAX_FRAME];
    let sequence = vector["sequence"].as_u64().unwrap() as u8;
    let length = framing::encode_message(&message, sequence, &mut wire);
    assert_eq!(wire[..length], bytes(&vector["frame"]));
}

macro_rules! dispatch {
    ($vector:expr, $($name:ident)*) => {
        match $vector["message"].as_str().unwrap() {
            $(stringify!($name) => check::<messages::$name>($vector),)*
            other => panic!("{other} has vectors but is not tested here"),
        }
    };
}

#[test]
fn every_message_reads_and_writes_its_golden_payload_and_frame() {
    let vectors = vectors("messages");
    assert!(vectors.len() > 60);
    for vector in &vectors {
        dispatch!(vector,
            EmergencyStop Stop Arm Disarm KeepAlive ClockRequest ClockReply SegmentTravel SegmentHeading
            SegmentStart MotionStatus State WheelTicks OdometryPosition OdometryHeading Velocity
            ReferenceDistance InertialHeading Gravity Sonar Battery MotorDuty Fault LinkStatistics LogText Hello HelloReply
            HelloBuild HelloBusy ParameterGet ParameterSet ParameterValue ParameterCommand TelemetryRate
            TestMode InjectWheels InjectSensors Reboot CrashRequest CrashCause CrashTime CrashEvent);
    }
}

#[test]
fn damaged_streams_yield_the_good_frames_and_counters() {
    for vector in vectors("streams") {
        let mut decoder = framing::Decoder::new();
        let frames: Vec<Value> = bytes(&vector["input"])
            .into_iter()
            .filter_map(|byte| decoder.push(byte))
            .map(|frame| {
                let hex: String = frame.payload().iter().map(|b| format!("{b:02x}")).collect();
                serde_json::json!([frame.identifier, frame.sequence, hex])
            })
            .collect();
        let name = &vector["name"];
        assert_eq!(vector["frames"], Value::Array(frames), "{name}");
        assert_eq!(vector["checksum_errors"], decoder.checksum_errors, "{name}");
        assert_eq!(vector["malformed"], decoder.malformed, "{name}");
        assert_eq!(vector["lost"], decoder.lost, "{name}");
    }
}

#[test]
fn the_checksum_has_the_published_check_value() {
    assert_eq!(framing::crc16(b"123456789"), 0x29b1);
}
