// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/catalog/DemoCatalog.h"

#include <memory>

namespace browser
{
/// A demo in two copies, with the same start and parameters: Bullet's own contact on the left, ours on the right. The figures are ours,
/// followed by those of Bullet, which are not judged. A device moves the hands of both; the mouse moves the hand under it.
class BesideStock final : public BrowsableDemo
{
public:
	/// `make` makes a demo for which hasStockSide() is true.
	explicit BesideStock(std::unique_ptr<BrowsableDemo> (*make)());

	std::optional<ist::Error> prepare(const DemoOptions& options) override;
	std::optional<ist::Error> restart() override;
	void step(double seconds) override;
	double stepSize() const override { return m_ours->stepSize(); }
	double duration() const override { return m_ours->duration(); }
	double time() const override { return m_ours->time(); }
	/// Draws our half.
	void draw(const DrawChoice& choice, DrawList& list) override { m_ours->draw(choice, list); }
	Viewpoint viewpoint() const override { return m_ours->viewpoint(); }
	DrawChoice firstChoice() const override { return m_ours->firstChoice(); }
	std::vector<Half> halves() override { return {{m_stock.get(), "stock Bullet"}, {m_ours.get(), "BulletHaptics"}}; }
	std::vector<Parameter> parameters() override { return m_ours->parameters(); }
	std::vector<Figure> figures() const override;
	std::vector<Curve> curves() const override;
	std::vector<std::string> report() const override;
	std::string reportJson() const override { return m_ours->reportJson(); }
	void setContactCache(const ContactCacheChoice& contactCache) override { m_ours->setContactCache(contactCache); }

	/// Grabs in our half; use `halves` for the other one.
	std::optional<double> grab(const ist::Vec3& from, const ist::Vec3& direction) override { return m_ours->grab(from, direction); }
	bool grabTool() override;
	void drag(const ist::Vec3& shift, const ist::Vec3& turn) override;
	void release() override;
	void keepAwake(bool on) override;

private:
	void shareParameters();

	std::unique_ptr<BrowsableDemo> m_ours, m_stock;
};

/// Makes a demo of the catalog. `besideStock`: beside its copy in stock Bullet, if possible.
std::unique_ptr<BrowsableDemo> makeDemo(const DemoEntry& entry, bool besideStock);
}  // namespace browser
