// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeWorker.h"

#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace ist
{
struct TreeWorker::Shared
{
	struct Job
	{
		std::shared_ptr<TreeOrder> order;
		Mesh mesh;
		BuildOptions options;
		std::string path;                                  // file to load; empty when the tree is built
		std::shared_ptr<const TreeOrder> plain = nullptr;  // order of the plain tree when levels are added to it
	};

	std::string folder;
	double mostDoubt;
	std::mutex mutex;
	std::condition_variable work, idle;
	std::deque<Job> jobs;
	bool busy = false;
	std::atomic<bool> stop{false};
	std::map<std::string, std::weak_ptr<TreeOrder>> known;
	std::thread thread;

	std::shared_ptr<const TreeOrder> request(const std::string& key, Job job)
	{
		const std::lock_guard<std::mutex> lock(mutex);
		std::weak_ptr<TreeOrder>& slot = known[key];
		const auto there = slot.lock();
		if (there && (!there->isDone() || there->tree())) return there;
		job.order = std::make_shared<TreeOrder>();
		job.order->m_plain = job.plain;
		slot = job.order;
		const auto order = job.order;
		jobs.push_back(std::move(job));
		work.notify_one();
		return order;
	}

	/// Takes the next job. Returns nothing once the worker must stop. The job has no order if no other reference to that order is left.
	std::optional<Job> next()
	{
		std::unique_lock<std::mutex> lock(mutex);
		work.wait(lock, [this] { return stop || !jobs.empty(); });
		if (stop) return {};
		std::optional<Job> job = std::move(jobs.front());
		jobs.pop_front();
		busy = true;
		// No other thread can obtain a reference: `known` is guarded by this mutex.
		if (job->order.use_count() == 1) job->order.reset();
		return job;
	}

	void jobHasEnded()
	{
		const std::lock_guard<std::mutex> lock(mutex);
		std::erase_if(known, [](const auto& entry) { return entry.second.expired(); });
		busy = false;
		if (jobs.empty()) idle.notify_all();
	}

	void run()
	{
		// Jobs are destroyed outside the lock, because what `progress` has captured may call the worker.
		while (std::optional<Job> job = next())
		{
			if (job->order) carryOut(*job);
			job.reset();
			jobHasEnded();
		}
		std::deque<Job> left;
		{
			const std::lock_guard<std::mutex> lock(mutex);
			left.swap(jobs);
		}
		for (Job& job : left) fail(*job.order, "the worker was stopped before its turn came");
		idle.notify_all();
	}

	static void fail(TreeOrder& order, std::string reason)
	{
		order.m_error = std::move(reason);
		order.m_done.store(true, std::memory_order_release);
	}

	void carryOut(Job& job)
	{
		try
		{
			Result<CachedTree> made = job.plain ? levelled(*job.plain) : job.path.empty() ? built(job) : loaded(job.path);
			if (!made) return fail(*job.order, made.error().message);
			job.order->m_result = std::move(made).value();
			job.order->m_done.store(true, std::memory_order_release);
		}
		catch (const std::exception& exception)
		{
			fail(*job.order, std::string("no tree could be built: ") + exception.what());
		}
		catch (...)
		{
			fail(*job.order, "no tree could be built: something was thrown that is no std::exception");
		}
	}

	Result<CachedTree> built(Job& job)
	{
		const Progress theirs = job.options.progress;
		job.options.progress = [this, theirs](const char* stage, double fraction) { return !stop && (!theirs || theirs(stage, fraction)); };
		return cachedTree(job.mesh, job.options, folder, mostDoubt);
	}

	static Result<CachedTree> levelled(const TreeOrder& plain)
	{
		CachedTree result = plain.m_result;
		const auto tree = std::make_shared<InnerSphereTree>(*result.tree);
		ist::addLevels(*tree);
		result.tree = tree;
		return result;
	}

	static Result<CachedTree> loaded(const std::string& path)
	{
		Result<InnerSphereTree> tree = loadAsset(path);
		if (!tree) return tree.error();
		CachedTree result;
		result.tree = std::make_shared<const InnerSphereTree>(std::move(tree).value());
		return result;
	}
};

TreeWorker::TreeWorker(std::string cacheFolder, double mostDoubt) : m_shared(std::make_unique<Shared>())
{
	m_shared->folder = std::move(cacheFolder);
	m_shared->mostDoubt = mostDoubt;
	m_shared->thread = std::thread([shared = m_shared.get()] { shared->run(); });
}

TreeWorker::~TreeWorker()
{
	{
		const std::lock_guard<std::mutex> lock(m_shared->mutex);
		m_shared->stop = true;
	}
	m_shared->work.notify_one();
	m_shared->thread.join();
}

std::shared_ptr<const TreeOrder> TreeWorker::build(Mesh mesh, const BuildOptions& options)
{
	const std::string key = "mesh " + std::to_string(treeKey(mesh, options));
	return m_shared->request(key, {nullptr, std::move(mesh), options, ""});
}

std::shared_ptr<const TreeOrder> TreeWorker::load(const std::string& path)
{
	return m_shared->request("file " + path, {nullptr, {}, {}, path});
}

std::shared_ptr<const TreeOrder> TreeWorker::addLevels(std::shared_ptr<const TreeOrder> plain)
{
	// The order holds `plain`, so no other order can have its address while this one is known.
	const std::string key = "levels of " + std::to_string(reinterpret_cast<uintptr_t>(plain.get()));
	return m_shared->request(key, {nullptr, {}, {}, "", std::move(plain)});
}

void TreeWorker::finish()
{
	std::unique_lock<std::mutex> lock(m_shared->mutex);
	m_shared->idle.wait(lock, [this] { return m_shared->jobs.empty() && !m_shared->busy; });
}
}  // namespace ist
