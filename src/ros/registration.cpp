#include "registration.h"

#include <ros/connection_manager.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/ros.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>

#include <utility>

namespace mass_spring {

namespace {

constexpr std::chrono::seconds kAskingPeriod(1);

using XmlRpc::XmlRpcValue;

/// A call of the master's interface, whose first argument is this node. Tries once.
bool ask(const char* method, const std::vector<std::string>& arguments, XmlRpcValue& answer) {
  XmlRpcValue request, response;
  request[0] = ros::this_node::getName();
  for (std::size_t k = 0; k < arguments.size(); ++k)
    request[static_cast<int>(k) + 1] = arguments[k];
  return ros::master::execute(method, request, response, answer, false);
}

/// A call of the interface that this node has for the master and others.
bool askSelf(const char* method, const XmlRpcValue& request, XmlRpcValue& answer) {
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(ros::XMLRPCManager::instance()->getServerURI(), host, port)) {
    return false;
  }
  XmlRpc::XmlRpcClient self(host.c_str(), static_cast<int>(port), "/");
  XmlRpcValue response;
  return self.execute(method, request, response) &&
         ros::XMLRPCManager::instance()->validateXmlrpcResponse(method, response, answer);
}

/// Topics and their types. @param method  getPublications or getSubscriptions
std::vector<std::pair<std::string, std::string>> topicsAndTypes(const char* method) {
  XmlRpcValue request, answer;
  request[0] = ros::this_node::getName();
  std::vector<std::pair<std::string, std::string>> found;
  if (!askSelf(method, request, answer)) return found;
  for (int k = 0; k < answer.size(); ++k) {
    found.emplace_back(static_cast<std::string&>(answer[k][0]),
                       static_cast<std::string&>(answer[k][1]));
  }
  return found;
}

}  // namespace

Registration::Registration(std::vector<std::string> services)
    : services_(std::move(services)), thread_([this] { run(); }) {}

Registration::~Registration() {
  stop(std::chrono::milliseconds(0));
  thread_.join();
}

bool Registration::stop(std::chrono::milliseconds patience) {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  stopped_.notify_one();
  return ended_.wait_for(patience) == std::future_status::ready;
}

void Registration::run() {
  while (true) {
    {
      std::unique_lock lock(mutex_);
      if (stopped_.wait_for(lock, kAskingPeriod, [this] { return stopping_; })) break;
    }
    look();
  }
  ended_promise_.set_value();
}

void Registration::look() {
  XmlRpcValue answer;
  const bool known = ask("lookupNode", {ros::this_node::getName()}, answer);
  const bool reached = known || ask("getPid", {}, answer);
  if (!reached && reached_) {
    ROS_ERROR_STREAM("The master at "
                     << ros::master::getURI()
                     << " does not answer. The simulation runs on for the nodes that know it.");
  } else if (reached && !reached_) {
    ROS_INFO("The master answers again.");
  }
  reached_ = reached;
  if (reached && !known && !ros::isShuttingDown()) registerAgain();
}

void Registration::registerAgain() const {
  const std::string uri = ros::XMLRPCManager::instance()->getServerURI();
  XmlRpcValue answer;
  std::size_t count = 0;
  for (const auto& [topic, type] : topicsAndTypes("getPublications")) {
    if (ask("registerPublisher", {topic, type, uri}, answer)) ++count;
  }
  for (const auto& [topic, type] : topicsAndTypes("getSubscriptions")) {
    if (!ask("registerSubscriber", {topic, type, uri}, answer)) continue;
    ++count;
    // To be told of no publisher would cut the links to those that the master has forgotten, too.
    if (answer.size() == 0) continue;
    XmlRpcValue update, ignored;
    update[0] = "/master";
    update[1] = topic;
    update[2] = answer;
    askSelf("publisherUpdate", update, ignored);
  }
  const std::string service_uri = "rosrpc://" + ros::network::getHost() + ":" +
                                  std::to_string(ros::ConnectionManager::instance()->getTCPPort());
  for (const std::string& service : services_) {
    if (ask("registerService", {service, service_uri, uri}, answer)) ++count;
  }
  ROS_WARN_STREAM("The master had forgotten this node, as it was started anew: registered "
                  << count
                  << " topics and services again. Its parameters are lost, also /use_sim_time: "
                     "~reload needs those of the scene.");
}

}  // namespace mass_spring
