// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/catalog/DemoCatalog.h"

#include <memory>

namespace browser
{
/// A demo twice, from the same start and with the same parameters: on the left Bullet's own contact answers, on the right ours. Figures are
/// ours; those of stock Bullet follow, and nobody judges them. A device moves the hands of both, the mouse that under it.
class BesideStock final : public BrowsableDemo
{
public:
	/// `make`: of a demo that hasStockSide().
	explicit BesideStock(std::unique_ptr<BrowsableDemo> (*make)());

	std::optional<ist::Error> prepare(const DemoOptions& options) override;
	std::optional<ist::Error> restart() override;
	void step(double seconds) override;
	double stepSize() const override { return m_ours->stepSize(); }
	double duration() const override { return m_ours->duration(); }
	double time() const override { return m_ours->time(); }
	/// Our half.
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

	/// In our half; `halves` for the other one.
	std::optional<double> grab(const ist::Vec3& from, const ist::Vec3& direction) override { return m_ours->grab(from, direction); }
	bool grabTool() override;
	void drag(const ist::Vec3& shift, const ist::Vec3& turn) override;
	void release() override;
	void keepAwake(bool on) override;

private:
	void shareParameters();

	std::unique_ptr<BrowsableDemo> m_ours, m_stock;
};

/// A demo of the catalog; `besideStock`: beside itself in stock Bullet, where that can be.
std::unique_ptr<BrowsableDemo> makeDemo(const DemoEntry& entry, bool besideStock);
}  // namespace browser
