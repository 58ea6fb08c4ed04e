// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/ContactView.h"
#include "demos/browser/base/ForceHand.h"
#include "demos/browser/base/HandPull.h"

#include <memory>
#include <string>
#include <vector>

struct btISTSceneReport;

namespace browser
{
/// Common part of demos with Bullet worlds: stepping, drawing, plots, the hand. A demo builds its bodies and names its figures.
class WorldDemo : public BrowsableDemo
{
public:
	std::optional<ist::Error> restart() final;
	void step(double seconds) final;
	double time() const final { return m_time; }
	void draw(const DrawChoice& choice, DrawList& list) final;
	std::vector<Curve> curves() const override;
	std::vector<std::string> report() const override;
	std::string reportJson() const override;
	ist::Result<std::vector<std::string>> saveScene(const std::string& path) override;
	void setContactCache(const ContactCacheChoice& contactCache) override;
	void useStockContact(bool on) override { m_stock = on; }
	/// All worlds that step, for measurements.
	std::vector<DemoWorld*> worlds() const;
	std::optional<double> grab(const ist::Vec3& from, const ist::Vec3& direction) override;
	bool grabTool() override;
	void drag(const ist::Vec3& shift, const ist::Vec3& turn) override { m_hand.move(shift, turn); }
	void release() override { m_hand.release(); }
	void keepAwake(bool on) override;
	/// The hand feels a ball above the highest point, which is there as long as it is felt.
	std::optional<ist::Error> feelWith(devicebridge::Device& device, double scale) override;
	void stopFeeling() override;
	std::string felt() const override;

protected:
	/// A hand at the device feels `tool`, a body of the first world.
	std::optional<ist::Error> feel(devicebridge::Device& device, btRigidBody& tool, double scale);
	bool isFelt() const { return m_forces != nullptr; }
	/// Adds a world. The picture shows it at `shift`, under its title, and magnified by `zoom`. A magnified world steps slower by the
	/// root of the zoom, as falling does, so that all sizes move alike.
	DemoWorld& addWorld(
		const ist::Vec3& gravity = {0, -9.81, 0}, const ist::Vec3& shift = {}, const std::string& title = {}, double zoom = 1);
	DemoWorld& world(size_t i = 0) { return *m_parts[i].world; }
	const DemoWorld& world(size_t i = 0) const { return *m_parts[i].world; }
	/// Called before the worlds are destroyed, for objects that must not outlive them.
	virtual void leave() {}
	/// Builds the scene. Errors of the worlds are checked by the caller.
	virtual std::optional<ist::Error> build() = 0;
	virtual void beforeStep(double /*h*/) {}
	virtual void afterStep(double /*h*/) {}
	/// Name of a body in the report.
	virtual std::string nameOf(const btCollisionObject* object) const;
	/// Adds further drawings, and the ground.
	virtual void decorate(const DrawChoice& /*choice*/, DrawList& /*list*/) {}
	/// Force whose arrow has the length `arrowLength` [N].
	virtual double arrowForce() const = 0;
	virtual double arrowLength() const = 0;
	HandPull& hand() { return m_hand; }
	/// Body that the hand of a saved scene holds; null: none.
	virtual const btRigidBody* sceneTool() const { return m_ball ? m_ball : m_hand.body(); }

private:
	struct Part
	{
		std::unique_ptr<DemoWorld> world;
		ist::Vec3 shift;
		std::string title;
		double zoom = 1;
	};
	void sample();
	void applyContactCache(Part& part) const;
	btISTSceneReport sceneReport(const Part& part) const;

	std::vector<Part> m_parts;
	std::unique_ptr<ForceHand> m_forces;  // of the first world; null: no device feels
	btRigidBody* m_ball = nullptr;        // of a hand that feels a demo without a tool, in the first world
	HandPull m_hand;
	ContactView m_view;
	DrawList m_one;
	Curve m_force{"contact force", "N", {}}, m_pairs{"pairs", "", {}}, m_energy{"mechanical energy", "J", {}},
		m_cost{"time of a step", "us", {}};
	double m_time = 0, m_nextSample = 0;
	bool m_awake = true, m_stock = false;
	ContactCacheChoice m_contactCache;
};
}  // namespace browser
