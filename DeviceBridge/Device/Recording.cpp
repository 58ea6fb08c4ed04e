// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Device/Recording.h"

#include <algorithm>
#include <cstring>

#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "BulletISTCollision/Core/Asset/ByteStream.h"
#include "BulletISTCollision/Core/Asset/Checksum.h"
#include "BulletISTCollision/Core/Platform/MappedFile.h"

namespace devicebridge
{
namespace
{
using ist::ByteReader;
using ist::ByteWriter;

constexpr char kMagic[8] = "ISTDREC";
constexpr std::size_t kHeaderBytes = sizeof kMagic + 4, kChecksumBytes = 8;
constexpr std::size_t kTickBytes = 330, kHandBytes = 1 + 65 * kHandJoints;

void put(ByteWriter& out, double v) { out.f64(v); }
void put(ByteWriter& out, std::uint64_t v) { out.u64(v); }
void put(ByteWriter& out, std::int64_t v) { out.i64(v); }
void put(ByteWriter& out, std::uint32_t v) { out.u32(v); }
void put(ByteWriter& out, bool v) { out.u8(v); }
void put(ByteWriter& out, DeviceStatus v) { out.u8(static_cast<std::uint8_t>(v)); }
void put(ByteWriter& out, const std::string& v) { out.text(v); }

void get(ByteReader& in, double& v) { v = in.f64(); }
void get(ByteReader& in, std::uint64_t& v) { v = in.u64(); }
void get(ByteReader& in, std::int64_t& v) { v = in.i64(); }
void get(ByteReader& in, std::uint32_t& v) { v = in.u32(); }
void get(ByteReader& in, std::string& v) { v = in.text(); }
void get(ByteReader& in, bool& v)
{
	const std::uint8_t byte = in.u8();
	if (byte > 1) in.fail();
	v = byte == 1;
}
void get(ByteReader& in, DeviceStatus& v)
{
	const std::uint8_t byte = in.u8();
	if (byte > static_cast<std::uint8_t>(DeviceStatus::Refused)) in.fail();
	v = static_cast<DeviceStatus>(byte);
}
void get(ByteReader& in, Handedness& v)
{
	const std::uint8_t byte = in.u8();
	if (byte > static_cast<std::uint8_t>(Handedness::Right)) in.fail();
	v = static_cast<Handedness>(byte);
}

// Each list of fields is written once and used for reading and writing.
template <class Visit> void visitVector(ist::Vec3& v, const Visit& visit) { visit(v.x), visit(v.y), visit(v.z); }

template <class Visit> void visitInfo(DeviceInfo& i, const Visit& visit)
{
	visit(i.model), visit(i.maker), visit(i.serial), visit(i.uri), visit(i.source);
	visit(i.sensed), visit(i.actuated);
	visit(i.peakForce), visit(i.continuousForce), visit(i.peakTorque), visit(i.continuousTorque);
	visit(i.maxStiffness), visit(i.maxAngularStiffness), visit(i.maxDamping), visit(i.maxAngularDamping);
	visit(i.resolution), visit(i.angularResolution), visit(i.workspaceRadius), visit(i.nominalRate);
}

template <class Visit> void visitTick(RecordedTick& t, const Visit& visit)
{
	visit(t.now), visit(t.readStatus), visit(t.writeStatus), visit(t.written);
	DeviceState& s = t.state;
	visit(s.sequence), visit(s.sampledAt);
	for (auto& row : s.X_WH.rotation.m)
		for (double& entry : row) visit(entry);
	visitVector(s.X_WH.translation, visit);
	visitVector(s.twist.linear, visit), visitVector(s.twist.angular, visit);
	visit(s.buttons), visit(s.flags), visit(s.gripAngle), visit(s.gripVelocity), visit(s.velocityEstimated);
	DeviceCommand& c = t.command;
	visit(c.sequence), visit(c.basedOn), visit(c.computedAt), visit(c.expiresAt);
	visitVector(c.wrench.force, visit), visitVector(c.wrench.torque, visit);
	visit(c.gripForce);
}

template <class Visit> void visitHand(HandState& h, const Visit& visit)
{
	visit(h.left);
	for (HandJoint& j : h.joints)
	{
		visitVector(j.position, visit);
		visit(j.orientation.x), visit(j.orientation.y), visit(j.orientation.z), visit(j.orientation.w);
		visit(j.radius), visit(j.tracked);
	}
}

/// Whether the times are far from overflow, because they are shifted to other clocks and their sums must stay valid.
bool areTimesSane(const RecordedTick& t)
{
	constexpr std::int64_t kLatest = std::int64_t(1) << 60;  // [ns]
	const auto isSane = [](std::int64_t time) { return time > -kLatest && time < kLatest; };
	return isSane(t.now) && isSane(t.state.sampledAt) && isSane(t.command.computedAt) && isSane(t.command.expiresAt);
}

ist::Error refused(const std::string& why) { return {"Not a readable recording: " + why, false}; }
}  // namespace

std::vector<std::byte> encodeRecording(const Recording& recording)
{
	ByteWriter out;
	out.reserve(4096 + kTickBytes * recording.ticks.size() + kHandBytes * recording.hands.size());
	for (const char c : kMagic) out.u8(static_cast<std::uint8_t>(c));
	out.u32(kRecordingVersion);
	const auto write = [&](const auto& v) { put(out, v); };
	DeviceInfo info = recording.info;
	visitInfo(info, write);
	out.u64(recording.dropped);
	out.u64(recording.ticks.size());
	for (RecordedTick tick : recording.ticks) visitTick(tick, write);
	out.u64(recording.hands.size());
	for (HandState hand : recording.hands) visitHand(hand, write);
	out.u8(static_cast<std::uint8_t>(info.handedness));
	out.u64(ist::checksum64(out.bytes().data(), out.size()));
	return out.take();
}

ist::Result<Recording> decodeRecording(const std::byte* bytes, std::size_t size)
{
	if (size < kHeaderBytes + kChecksumBytes) return refused("it ends after " + std::to_string(size) + " bytes");
	if (std::memcmp(bytes, kMagic, sizeof kMagic) != 0) return refused("it does not begin with ISTDREC");
	const std::uint32_t version = ist::loadU32(bytes + sizeof kMagic);
	if (version < 1 || version > kRecordingVersion)
		return refused("its version is " + std::to_string(version) + ", this library reads " + std::to_string(kRecordingVersion));
	const std::size_t body = size - kChecksumBytes;
	if (ist::loadU64(bytes + body) != ist::checksum64(bytes, body)) return refused("its checksum is wrong: it was cut or changed");

	ByteReader in(bytes + kHeaderBytes, body - kHeaderBytes);
	const auto read = [&](auto& v) { get(in, v); };
	Recording recording;
	visitInfo(recording.info, read);
	recording.dropped = in.u64();
	// A tick takes more than 256 bytes, so a count cannot request more memory than the file's size.
	recording.ticks.resize(in.count(256));
	for (RecordedTick& tick : recording.ticks) visitTick(tick, read);
	if (version >= 2) recording.hands.resize(in.count(kHandBytes));
	for (HandState& hand : recording.hands) visitHand(hand, read);
	if (version >= 3) get(in, recording.info.handedness);
	if (!recording.hands.empty() && recording.hands.size() != recording.ticks.size()) in.fail();
	if (!in.complete()) return refused("its fields and its length do not agree");
	const auto insane = std::find_if_not(recording.ticks.begin(), recording.ticks.end(), areTimesSane);
	if (insane != recording.ticks.end())
		return refused("a time of its tick " + std::to_string(insane - recording.ticks.begin()) +
			" lies more than 36 years from the zero of its clock");
	return recording;
}

ist::Result<std::size_t> saveRecording(const Recording& recording, const std::string& path)
{
	const std::vector<std::byte> bytes = encodeRecording(recording);
	return ist::writeFileAtomically(path, bytes.data(), bytes.size());
}

ist::Result<Recording> loadRecording(const std::string& path)
{
	const ist::Result<ist::MappedFile> file = ist::MappedFile::open(path);
	if (!file) return file.error();
	ist::Result<Recording> recording = decodeRecording(file.value().bytes(), file.value().size());
	if (!recording) return ist::Error{path + ": " + recording.error().message, false};
	return recording;
}
}  // namespace devicebridge
