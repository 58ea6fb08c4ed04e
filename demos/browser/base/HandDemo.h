// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Bullet/BulletHand.h"
#include "DeviceBridge/Hand/HandPosture.h"
#include "demos/browser/base/WorldDemo.h"
#include "demos/browser/drawing/PackedSpheres.h"

namespace browser
{
/// A demo with a hand of sixteen parts that follows a motion. When the user grabs one of the parts, the whole hand follows the user.
class HandDemo : public WorldDemo
{
public:
	std::optional<double> grab(const ist::Vec3& from, const ist::Vec3& direction) override;
	bool grabTool() override;
	void drag(const ist::Vec3& shift, const ist::Vec3& turn) override;
	void release() override;

protected:
	/// Makes the hand's model; call it once, in `prepare`.
	std::optional<ist::Error> prepareHand(const devicebridge::GloveHandSize& size, const DemoOptions& options);
	/// Adds the hand at the start of the motion; call it once, in `build`.
	std::optional<ist::Error> putHand(DemoWorld& world, const devicebridge::BulletHandSettings& settings = {});
	/// Posture of the hand at a time [s].
	virtual devicebridge::HandPosture motion(double time) const = 0;
	bool hasHand() const { return m_parts != nullptr; }
	const devicebridge::BulletHand& parts() const { return *m_parts; }
	const devicebridge::HandModel& model() const { return *m_model; }
	ist::Pose X_WB(int part) const;  ///< pose of a part's body
	std::string nameOf(const btCollisionObject* object) const override;
	void leave() override { m_parts.reset(); }
	void beforeStep(double h) override;
	void drawHand(const DrawChoice& choice, DrawList& list) const;

private:
	void take();

	devicebridge::GloveHandSize m_size;
	std::shared_ptr<const devicebridge::HandModel> m_model;
	std::shared_ptr<const SurfaceModel> m_skins[devicebridge::kHandParts];
	PackedSpheres m_spheres[devicebridge::kHandParts];
	std::unique_ptr<devicebridge::BulletHand> m_parts;
	devicebridge::HandPosture m_posture;  // posture after the user has grabbed the hand
	bool m_taken = false, m_led = false;
};

/// Colour of a part's finger, by the part's number in the GRAB data set (handPartId).
Colour fingerColour(int grabId);
}  // namespace browser
