// SPDX-License-Identifier: Zlib
#include "demos/browser/catalog/BesideStock.h"

#include <algorithm>

using namespace ist;

namespace browser
{
namespace
{
const char* const kInStock = " in stock Bullet";
}

BesideStock::BesideStock(std::unique_ptr<BrowsableDemo> (*make)()) : m_ours(make()), m_stock(make()) { m_stock->useStockContact(true); }

std::optional<Error> BesideStock::prepare(const DemoOptions& options)
{
	if (auto error = m_ours->prepare(options)) return error;
	return m_stock->prepare(options);
}

void BesideStock::shareParameters()
{
	const std::vector<Parameter> from = m_ours->parameters(), to = m_stock->parameters();
	for (size_t i = 0; i < from.size(); ++i) *to[i].value = *from[i].value;
}

std::optional<Error> BesideStock::restart()
{
	shareParameters();
	if (auto error = m_ours->restart()) return error;
	return m_stock->restart();
}

void BesideStock::step(double seconds)
{
	shareParameters();
	m_ours->step(seconds);
	m_stock->step(seconds);
}

std::vector<Figure> BesideStock::figures() const
{
	std::vector<Figure> all = m_ours->figures();
	for (const Figure& f : m_stock->figures())
		// A value that stock Bullet does not have is not shown.
		if (std::isfinite(f.value)) all.push_back({f.name + kInStock, f.unit, f.value});
	return all;
}

std::vector<Curve> BesideStock::curves() const
{
	std::vector<Curve> all = m_ours->curves();
	for (Curve& curve : m_stock->curves())
	{
		if (std::all_of(curve.values.begin(), curve.values.end(), [](float v) { return v == 0; })) continue;
		curve.name += kInStock;
		all.push_back(std::move(curve));
	}
	return all;
}

std::vector<std::string> BesideStock::report() const
{
	std::vector<std::string> rows = m_ours->report();
	for (const std::string& row : m_stock->report()) rows.push_back("stock Bullet: " + row);
	return rows;
}

bool BesideStock::grabTool()
{
	const bool ours = m_ours->grabTool(), stock = m_stock->grabTool();
	return ours || stock;
}

void BesideStock::drag(const Vec3& shift, const Vec3& turn)
{
	for (BrowsableDemo* half : {m_ours.get(), m_stock.get()}) half->drag(shift, turn);
}

void BesideStock::release()
{
	for (BrowsableDemo* half : {m_ours.get(), m_stock.get()}) half->release();
}

void BesideStock::keepAwake(bool on)
{
	for (BrowsableDemo* half : {m_ours.get(), m_stock.get()}) half->keepAwake(on);
}

std::unique_ptr<BrowsableDemo> makeDemo(const DemoEntry& entry, bool besideStock)
{
	std::unique_ptr<BrowsableDemo> demo = entry.make();
	if (!besideStock || !demo->hasStockSide()) return demo;
	return std::make_unique<BesideStock>(entry.make);
}
}  // namespace browser
