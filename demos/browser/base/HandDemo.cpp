// SPDX-License-Identifier: Zlib
#include "demos/browser/base/HandDemo.h"

#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Hand/Grasp/HeatMapFile.h"

using namespace ist;
using namespace devicebridge;

namespace browser
{
namespace
{
constexpr long long kPartSpheres = 150;

/// Colour of a part's skin: a pale version of its finger's colour.
Colour skinColour(int part) { return mixed({0.9f, 0.82f, 0.75f}, fingerColour(handPartId(part, false)), part == kHandPart ? 0.1 : 0.45); }
}  // namespace

Colour fingerColour(int grabId)
{
	const HeatMapColour c = handPartColour(grabId);
	return {float(c.r) / 255, float(c.g) / 255, float(c.b) / 255};
}

std::optional<Error> HandDemo::prepareHand(const GloveHandSize& size, const DemoOptions& options)
{
	m_size = size;
	const Result<HandShape> shape = measureHand(posedHand({}, size));
	if (!shape) return shape.error();
	const Result<std::shared_ptr<const HandModel>> made = buildHandModel(shape.value(), {kPartSpheres, options.cache, 0, options.progress});
	if (!made) return made.error();
	m_model = made.value();
	for (size_t i = 0; i < kHandParts; ++i)
	{
		m_skins[i] = makeSurfaceModel(m_model->parts[i].mesh);
		m_spheres[i] = PackedSpheres(m_model->parts[i].tree);
	}
	return std::nullopt;
}

std::optional<Error> HandDemo::putHand(DemoWorld& world, const BulletHandSettings& settings)
{
	m_taken = m_led = false;
	Result<std::unique_ptr<BulletHand>> made = BulletHand::create(*world.volumetric(), m_model, posedHand(motion(0), m_size), settings);
	if (!made) return made.error();
	m_parts = std::move(made).value();
	return std::nullopt;
}

Pose HandDemo::X_WB(int part) const { return toPose(m_parts->body(part).getWorldTransform()); }

std::string HandDemo::nameOf(const btCollisionObject* object) const
{
	const int part = m_parts ? m_parts->partOf(object) : -1;
	return part < 0 ? WorldDemo::nameOf(object) : handPartName(part, m_size.left);
}

void HandDemo::beforeStep(double h) { m_parts->drive(posedHand(m_taken ? m_posture : motion(time() + h), m_size), h); }

void HandDemo::take()
{
	if (!m_taken) m_posture = motion(time());
	m_taken = m_led = true;
}

std::optional<double> HandDemo::grab(const Vec3& from, const Vec3& direction)
{
	double nearest = -1;
	for (int i = 0; m_parts && i < kHandParts; ++i)
	{
		const double t = rayMeetsMesh(m_model->parts[size_t(i)].mesh, X_WB(i), from, direction);
		if (t > 0 && (nearest < 0 || t < nearest)) nearest = t;
	}
	const auto other = WorldDemo::grab(from, direction);
	if (nearest < 0 || (other && *other < nearest)) return other;
	WorldDemo::release();
	take();
	return nearest;
}

bool HandDemo::grabTool()
{
	if (!m_parts) return false;
	if (!m_led) take();
	return true;
}

void HandDemo::drag(const Vec3& shift, const Vec3& turn)
{
	if (!m_led) return WorldDemo::drag(shift, turn);
	// The rotation is about the middle of the palm, not the wrist.
	const Vec3 palm = X_WB(kHandPart).translation;
	Pose& X = m_posture.X_WR;
	const Mat3 R = rotationMatrix(quaternionFromRotationVector(turn));
	X.translation = palm + R * (X.translation - palm) + shift;
	X.rotation = rotationMatrix(quaternion(R * X.rotation));
}

void HandDemo::release()
{
	m_led = false;
	WorldDemo::release();
}

void HandDemo::drawHand(const DrawChoice& choice, DrawList& list) const
{
	for (int i = 0; i < kHandParts; ++i)
	{
		const Pose X = X_WB(i);
		if (choice.surfaces) list.surfaces.push_back({m_skins[size_t(i)], X, skinColour(i), 1, choice.showsInside()});
		m_spheres[size_t(i)].draw(choice, X, list);
	}
}
}  // namespace browser
