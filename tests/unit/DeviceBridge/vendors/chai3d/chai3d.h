// SPDX-License-Identifier: Zlib
#pragma once

// The part of CHAI3D's interface that the plug-in uses, so that it can be compiled and tested without CHAI3D. Names and signatures:
// src/devices/CGenericHapticDevice.h, src/devices/CHapticDeviceHandler.h, src/math/CVector3d.h and CMatrix3d.h of github.com/chai3d/chai3d,
// 3.3.0.
#include <memory>
#include <string>

namespace chai3d
{
class cVector3d
{
public:
	cVector3d() = default;
	cVector3d(double x, double y, double z) : m_x(x), m_y(y), m_z(z) {}
	double x() const { return m_x; }
	double y() const { return m_y; }
	double z() const { return m_z; }

private:
	double m_x = 0, m_y = 0, m_z = 0;
};

class cMatrix3d
{
public:
	void identity();
	void setCol(const cVector3d& c0, const cVector3d& c1, const cVector3d& c2) { m_columns[0] = c0, m_columns[1] = c1, m_columns[2] = c2; }
	cVector3d getCol0() const { return m_columns[0]; }
	cVector3d getCol1() const { return m_columns[1]; }
	cVector3d getCol2() const { return m_columns[2]; }

private:
	cVector3d m_columns[3];
};

struct cHapticDeviceInfo
{
	std::string m_modelName, m_manufacturerName;
	double m_maxLinearForce, m_maxAngularTorque, m_maxLinearStiffness, m_maxAngularStiffness, m_maxLinearDamping, m_maxAngularDamping,
		m_workspaceRadius;
	bool m_sensedPosition, m_sensedRotation, m_sensedGripper, m_actuatedPosition, m_actuatedRotation;
};

class cGenericHapticDevice
{
public:
	virtual ~cGenericHapticDevice() {}
	virtual bool open();
	virtual bool close();
	virtual bool calibrate(bool forceCalibration = false);
	virtual bool getPosition(cVector3d& position);
	virtual bool getLinearVelocity(cVector3d& velocity);
	virtual bool getRotation(cMatrix3d& rotation);
	virtual bool getAngularVelocity(cVector3d& velocity);
	virtual bool getGripperAngleRad(double& angle);
	virtual bool getUserSwitches(unsigned int& switches);
	virtual bool setForceAndTorqueAndGripperForce(const cVector3d& force, const cVector3d& torque, const double gripperForce);
	cHapticDeviceInfo getSpecifications();
};
typedef std::shared_ptr<cGenericHapticDevice> cGenericHapticDevicePtr;

class cHapticDeviceHandler
{
public:
	cHapticDeviceHandler();
	virtual ~cHapticDeviceHandler();
	unsigned int getNumDevices() { return m_numDevices; }
	bool getDevice(cGenericHapticDevicePtr& device, unsigned int index = 0);

private:
	unsigned int m_numDevices;
};
}  // namespace chai3d
