// Template of a ros2_control controller around an exported joint-impedance law. NOT RUN AGAINST ROS: see README.md.
#include <array>
#include <string>
#include <vector>

#include <controller_interface/controller_interface.hpp>
#include <hardware_interface/types/hardware_interface_type_values.hpp>
#include <pluginlib/class_list_macros.hpp>

extern "C" {
#include "amble_controller.h"
}

namespace amble_ros2 {

class AmbleController : public controller_interface::ControllerInterface {
 public:
  controller_interface::CallbackReturn on_init() override {
    auto_declare<std::vector<std::string>>("joints", {});  // in the order of amble_controller.h
    auto_declare<std::vector<std::string>>("contacts", {});  // sensors with an interface "contact", in its order of feet
    return controller_interface::CallbackReturn::SUCCESS;
  }

  controller_interface::InterfaceConfiguration command_interface_configuration() const override {
    controller_interface::InterfaceConfiguration found{controller_interface::interface_configuration_type::INDIVIDUAL, {}};
    for (const auto &joint : joints_) found.names.push_back(joint + "/" + hardware_interface::HW_IF_EFFORT);
    return found;
  }

  controller_interface::InterfaceConfiguration state_interface_configuration() const override {
    controller_interface::InterfaceConfiguration found{controller_interface::interface_configuration_type::INDIVIDUAL, {}};
    for (const auto &joint : joints_) found.names.push_back(joint + "/" + hardware_interface::HW_IF_POSITION);
    for (const auto &joint : joints_) found.names.push_back(joint + "/" + hardware_interface::HW_IF_VELOCITY);
    for (const auto &contact : contacts_) found.names.push_back(contact + "/contact");
    return found;
  }

  controller_interface::CallbackReturn on_configure(const rclcpp_lifecycle::State &) override {
    joints_ = get_node()->get_parameter("joints").as_string_array();
    contacts_ = get_node()->get_parameter("contacts").as_string_array();
    if (joints_.size() != AMBLE_JOINTS || contacts_.size() != AMBLE_FEET) {
      RCLCPP_ERROR(get_node()->get_logger(), "the gait has %d joints and %d feet", AMBLE_JOINTS, AMBLE_FEET);
      return controller_interface::CallbackReturn::ERROR;
    }
    return controller_interface::CallbackReturn::SUCCESS;
  }

  controller_interface::CallbackReturn on_activate(const rclcpp_lifecycle::State &) override {
    // the robot has to stand in the pose where the first stance begins: whoever brings it there activates
    return amble_enter(&controller_, 0) == AMBLE_OK ? controller_interface::CallbackReturn::SUCCESS
                                                    : controller_interface::CallbackReturn::ERROR;
  }

  controller_interface::return_type update(const rclcpp::Time &, const rclcpp::Duration &period) override {
    std::array<AMBLE_REAL, AMBLE_JOINTS> q{}, qd{};
    std::array<unsigned char, AMBLE_FEET> contact{};
    for (std::size_t i = 0; i < AMBLE_JOINTS; i++) {
      q[i] = static_cast<AMBLE_REAL>(state_interfaces_[i].get_value());
      qd[i] = static_cast<AMBLE_REAL>(state_interfaces_[AMBLE_JOINTS + i].get_value());
    }
    for (std::size_t i = 0; i < AMBLE_FEET; i++) contact[i] = state_interfaces_[2 * AMBLE_JOINTS + i].get_value() > 0.5;
    const unsigned status = amble_step(&controller_, static_cast<AMBLE_REAL>(period.seconds()), q.data(), qd.data(),
                                       contact.data(), &command_);
    for (std::size_t i = 0; i < AMBLE_JOINTS; i++) command_interfaces_[i].set_value(static_cast<double>(command_.sum[i]));
    const unsigned told = status & ~static_cast<unsigned>(AMBLE_SATURATED);
    if (told) RCLCPP_WARN_THROTTLE(get_node()->get_logger(), *get_node()->get_clock(), 1000, "amble: status %u", told);
    return controller_interface::return_type::OK;  // the fallback's damping is already in the command
  }

 private:
  std::vector<std::string> joints_, contacts_;
  amble_controller controller_{};
  amble_command command_{};
};

}  // namespace amble_ros2

PLUGINLIB_EXPORT_CLASS(amble_ros2::AmbleController, controller_interface::ControllerInterface)
