// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Glove/GloveCalibration.h"

#include "BulletISTCollision/Json/JsonValue.h"
#include <cmath>

#include "BulletISTCollision/Core/Platform/MappedFile.h"

namespace devicebridge
{
namespace
{
constexpr double kDegree = 3.14159265358979323846 / 180;
constexpr int kLeastSpan = 10;  // least difference of a sensor's values between the two poses

struct SensorRow
{
	const char* name;
	double span;  ///< range of the joint over the whole range of the sensor [rad]
	double fist;  ///< angle of the joint in a fist [rad]; zero: the fist does not define it
};

const SensorRow kRows[kGloveSensors] = {{"thumb_roll", 90 * kDegree, 0}, {"thumb_metacarpal_bend", 90 * kDegree, 50 * kDegree},
	{"thumb_bend", 90 * kDegree, 50 * kDegree}, {"thumb_abduction", 60 * kDegree, 0}, {"index_knuckle", 110 * kDegree, 90 * kDegree},
	{"index_middle", 120 * kDegree, 90 * kDegree}, {"index_end", 90 * kDegree, 60 * kDegree},
	{"middle_knuckle", 110 * kDegree, 90 * kDegree}, {"middle_middle", 120 * kDegree, 90 * kDegree},
	{"middle_end", 90 * kDegree, 60 * kDegree}, {"middle_index_abduction", 45 * kDegree, 0}, {"ring_knuckle", 110 * kDegree, 90 * kDegree},
	{"ring_middle", 120 * kDegree, 90 * kDegree}, {"ring_end", 90 * kDegree, 60 * kDegree}, {"ring_middle_abduction", 45 * kDegree, 0},
	{"little_knuckle", 110 * kDegree, 90 * kDegree}, {"little_middle", 120 * kDegree, 90 * kDegree},
	{"little_end", 90 * kDegree, 60 * kDegree}, {"little_ring_abduction", 45 * kDegree, 0}, {"palm_arch", 40 * kDegree, 0},
	{"wrist_pitch", 140 * kDegree, 0}, {"wrist_yaw", 60 * kDegree, 0}};
}  // namespace

GloveAngles GloveCalibration::angles(const GloveValues& values) const noexcept
{
	GloveAngles angles{};
	for (std::size_t i = 0; i < angles.size(); ++i)
	{
		const bool sensed = values[i] != 0 || !isDistal(static_cast<int>(i));
		angles[i] = sensed ? gain[i] * (values[i] - offset[i]) : 2.0 / 3 * angles[i - 1];
	}
	return angles;
}

GloveCalibration roughGloveCalibration()
{
	GloveCalibration rough;
	for (std::size_t i = 0; i < rough.gain.size(); ++i)
	{
		const bool wrist = i == kWristPitch || i == kWristYaw;
		rough.offset[i] = wrist ? 128 : 1;
		rough.gain[i] = kRows[i].span / 254;
	}
	return rough;
}

ist::Result<GloveCalibration> calibrateGlove(const GloveValues& flat, const GloveValues& fist, bool hasDistal)
{
	GloveCalibration result = roughGloveCalibration();
	for (std::size_t i = 0; i < result.gain.size(); ++i)
	{
		if (isDistal(static_cast<int>(i)) && !hasDistal) continue;
		result.offset[i] = flat[i];
		if (kRows[i].fist == 0) continue;
		const int span = fist[i] - flat[i];
		if (std::abs(span) < kLeastSpan)
			return ist::Error{"the sensor " + std::string(kRows[i].name) + " moves by " + std::to_string(std::abs(span)) +
					" steps between the flat hand and the fist; is the glove on, and were the poses held?",
				false};
		result.gain[i] = kRows[i].fist / span;
	}
	return result;
}

ist::Result<GloveCalibration> readGloveCalibration(const std::string& text)
{
	const ist::JsonValue file = ist::parseJson(text).value;
	const auto wrong = [](const std::string& why) { return ist::Error{"Not a glove calibration: " + why, false}; };
	if (!file.isObject()) return wrong("it is no JSON object");
	if (file["schema"] != 1) return wrong("its schema is not 1");
	if (!file["sensors"].isObject()) return wrong("it has no object 'sensors'");
	GloveCalibration result;
	for (std::size_t i = 0; i < result.gain.size(); ++i)
	{
		const std::string name = kRows[i].name;
		const ist::JsonValue& row = file["sensors"][name];
		if (!row.isObject()) return wrong("the sensor " + name + " is missing");
		for (const auto& [field, target] : {std::pair<const char*, double*>{"offset", &result.offset[i]}, {"gain", &result.gain[i]}})
		{
			if (!row[field].isNumber()) return wrong("the sensor " + name + " has no number '" + field + "'");
			*target = row[field].number();
			const double most = target == &result.gain[i] ? 1 : 1e4;
			if (!(std::fabs(*target) <= most)) return wrong("the " + std::string(field) + " of the sensor " + name + " is out of range");
		}
	}
	if (file["sensors"].size() != result.gain.size()) return wrong("it has a sensor of an unknown name");
	return result;
}

std::string writeGloveCalibration(const GloveCalibration& calibration)
{
	ist::JsonValue file = {{"schema", 1}};
	for (std::size_t i = 0; i < calibration.gain.size(); ++i)
		file["sensors"][kRows[i].name] = {{"offset", calibration.offset[i]}, {"gain", calibration.gain[i]}};
	return file.dump(true) + "\n";
}

ist::Result<GloveCalibration> loadGloveCalibration(const std::string& path)
{
	const ist::Result<ist::MappedFile> file = ist::MappedFile::open(path);
	if (!file) return file.error();
	auto read = readGloveCalibration({reinterpret_cast<const char*>(file.value().bytes()), file.value().size()});
	if (!read) return ist::Error{path + ": " + read.error().message, false};
	return read;
}
}  // namespace devicebridge
